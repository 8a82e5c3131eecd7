#include "app/sensor_conversation.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::sensor_conversation_test {
namespace {

using namespace std::chrono_literals;
using Outcomes = std::vector<SensorOutcome>;
constexpr auto kAnswered = SensorOutcome::answered;
constexpr auto kMissed = SensorOutcome::missed;
constexpr auto kFree = SensorOutcome::free;

/// Passes frames with or without times to a conversation and keeps the results.
class Ear {
  public:
    explicit Ear(bool timed) : timed_(timed) {}
    // Not copied, because the conversation has a reference to it.
    Ear(const Ear&) = delete;
    Ear& operator=(const Ear&) = delete;

    void slot() {
        slot_ += 7700us;
        now_ = slot_;
    }
    void hear(SensorCommand command, std::uint8_t address, std::vector<std::uint8_t> data = {}) {
        HeardSensorFrame heard;
        heard.frame.command = command;
        heard.frame.address = address;
        heard.frame.data_size = static_cast<std::uint8_t>(data.size());
        std::copy(data.begin(), data.end(), heard.frame.data.begin());
        if (timed_) {
            heard.start = now_;
            heard.end = now_ + 370us;
        }
        now_ += 370us + 630us;
        conversation.hear(heard);
    }
    void ask(SensorCommand command, std::uint8_t address) {
        slot();
        hear(command, address);
    }
    Outcomes outcomes() {
        conversation.finish();
        Outcomes outcomes;
        for (const SensorExchange& exchange : told) {
            outcomes.push_back(exchange.outcome);
        }
        return outcomes;
    }

    std::vector<SensorExchange> told;
    SensorConversation conversation{
        [this](const SensorExchange& exchange) { told.push_back(exchange); }};

  private:
    bool timed_;
    Duration slot_{};
    Duration now_{};
};

class SensorConversationTest : public testing::TestWithParam<bool> {
  protected:
    Ear ear{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(TimedOrNot, SensorConversationTest, testing::Bool());

TEST_P(SensorConversationTest, AValueIsPairedWithItsRequest) {
    ear.ask(SensorCommand::value, 1);
    ear.hear(SensorCommand::value, 1, {7, 0});
    ASSERT_EQ(ear.outcomes(), Outcomes{kAnswered});
    EXPECT_EQ(ear.told[0].answer->frame.data[0], 7);
}

TEST_P(SensorConversationTest, ARequestThatIsRepeatedWasMissedAndAskedAgain) {
    ear.ask(SensorCommand::value, 1);
    ear.ask(SensorCommand::value, 1);
    ear.hear(SensorCommand::value, 1, {7, 0});
    ASSERT_EQ(ear.outcomes(), (Outcomes{kMissed, kAnswered}));
    EXPECT_TRUE(ear.told[0].asked_again);
    EXPECT_EQ(ear.conversation.counts().misses_asked_again, 1U);
}

TEST_P(SensorConversationTest, ARequestThatAnotherFollowsWasMissed) {
    ear.ask(SensorCommand::value, 1);
    ear.ask(SensorCommand::value, 2);
    ear.hear(SensorCommand::value, 2, {7, 0});
    ASSERT_EQ(ear.outcomes(), (Outcomes{kMissed, kAnswered}));
    EXPECT_FALSE(ear.told[0].asked_again);
}

TEST_P(SensorConversationTest, AnAnswerOfAnotherAddressIsUnasked) {
    ear.ask(SensorCommand::value, 1);
    ear.hear(SensorCommand::value, 2, {7, 0});
    EXPECT_EQ(ear.outcomes(), (Outcomes{kMissed, SensorOutcome::unasked}));
}

TEST_P(SensorConversationTest, ARequestAtTheEndIsNoMiss) {
    ear.ask(SensorCommand::value, 1);
    EXPECT_EQ(ear.outcomes(), Outcomes{SensorOutcome::cut});
    EXPECT_EQ(ear.conversation.counts().misses, 0U);
}

TEST_P(SensorConversationTest, PowerUpFramesStandAlone) {
    ear.ask(SensorCommand::power_up, 0);
    ear.ask(SensorCommand::power_up, 0);
    EXPECT_EQ(ear.outcomes(), Outcomes(2, SensorOutcome::power_up));
    EXPECT_EQ(ear.conversation.counts().power_up, 2U);
}

TEST_P(SensorConversationTest, DiscoverThatIsHeardTwiceAndThenAskedForItsTypeIsAnswered) {
    ear.ask(SensorCommand::discover, 1);
    ear.hear(SensorCommand::discover, 1);
    ear.ask(SensorCommand::type, 1);
    ear.hear(SensorCommand::type, 1, {3, 2});
    ASSERT_EQ(ear.outcomes(), (Outcomes{kAnswered, kAnswered}));
    EXPECT_EQ(ear.told[1].type->id, 3);
    EXPECT_EQ(ear.told[1].type->size, 2);
}

TEST_P(SensorConversationTest, ASensorsTypeIsKnownFromThenOn) {
    ear.ask(SensorCommand::type, 2);
    ear.hear(SensorCommand::type, 2, {1, 2});
    ear.ask(SensorCommand::value, 2);
    ear.hear(SensorCommand::value, 2, {0, 0});
    ear.ask(SensorCommand::value, 1);
    ear.hear(SensorCommand::value, 1, {0, 0});
    ear.outcomes();
    EXPECT_EQ(ear.told[1].type->id, 1);
    EXPECT_FALSE(ear.told[2].type);
}

// A receiver without sensors sends 81 in every slot.
TEST_P(SensorConversationTest, DiscoverInEverySlotFindsNobody) {
    for (int slot = 0; slot < 5; ++slot) {
        ear.ask(SensorCommand::discover, 1);
    }
    ear.ask(SensorCommand::power_up, 0);
    EXPECT_EQ(ear.outcomes(),
              (Outcomes{kFree, kFree, kFree, kFree, kFree, SensorOutcome::power_up}));
    EXPECT_EQ(ear.conversation.counts().probes, 5U);
    EXPECT_EQ(ear.conversation.counts().requests, 0U);
}

TEST_P(SensorConversationTest, TheLastOfManyDiscoversIsAnsweredIfTheTypeIsAskedFor) {
    for (int slot = 0; slot < 4; ++slot) {
        ear.ask(SensorCommand::discover, 1);
    }
    ear.hear(SensorCommand::discover, 1);
    ear.ask(SensorCommand::type, 1);
    ear.hear(SensorCommand::type, 1, {3, 2});
    EXPECT_EQ(ear.outcomes(), (Outcomes{kFree, kFree, kFree, kAnswered, kAnswered}));
}

TEST_P(SensorConversationTest, AProbeAmongValuesFoundNobody) {
    ear.ask(SensorCommand::discover, 2);
    ear.ask(SensorCommand::value, 1);
    ear.hear(SensorCommand::value, 1, {0, 0});
    EXPECT_EQ(ear.outcomes(), (Outcomes{kFree, kAnswered}));
    EXPECT_EQ(ear.conversation.addresses()[2].probes, 1U);
}

TEST(SensorConversation, ResponseTimeRunsFromTheEndOfTheRequest) {
    Ear ear(true);
    ear.ask(SensorCommand::value, 1);
    ear.hear(SensorCommand::value, 1, {0, 0});
    ear.outcomes();
    EXPECT_EQ(ear.told[0].response_time, 630us);
    EXPECT_EQ(ear.conversation.addresses()[1].response_times, std::vector<Duration>{630us});
}

TEST(SensorConversation, ARequestThatIsHeardAgainAtOnceIsAnEcho) {
    Ear ear(true);
    ear.ask(SensorCommand::value, 1);
    ear.hear(SensorCommand::value, 1);
    ear.hear(SensorCommand::value, 1, {0, 0});
    ASSERT_EQ(ear.outcomes(), Outcomes{kAnswered});
    EXPECT_EQ(ear.told[0].echoes, 1U);
    EXPECT_EQ(ear.told[0].response_time, 630us);
}

TEST(SensorConversation, DiscoverWithEchoAndAnswerIsHeardThreeTimes) {
    Ear ear(true);
    ear.ask(SensorCommand::discover, 1);
    ear.hear(SensorCommand::discover, 1);
    ear.hear(SensorCommand::discover, 1);
    ear.ask(SensorCommand::type, 1);
    ASSERT_EQ(ear.outcomes(), (Outcomes{kAnswered, SensorOutcome::cut}));
    EXPECT_EQ(ear.told[0].echoes, 1U);
}

TEST(SensorConversation, DiscoverThatIsHeardTwiceAndNotFollowedByItsTypeIsAnEcho) {
    Ear ear(true);
    ear.ask(SensorCommand::discover, 2);
    ear.hear(SensorCommand::discover, 2);
    ear.ask(SensorCommand::value, 1);
    ASSERT_EQ(ear.outcomes(), (Outcomes{kFree, SensorOutcome::cut}));
    EXPECT_EQ(ear.told[0].echoes, 1U);
}

TEST(SensorConversation, DiscoverTwiceAtTheEndIsAnAnswerUnlessTheRecorderHearsItself) {
    Ear plain(true);
    plain.ask(SensorCommand::discover, 2);
    plain.hear(SensorCommand::discover, 2);
    EXPECT_EQ(plain.outcomes(), Outcomes{kAnswered});

    Ear echoing(true);
    echoing.ask(SensorCommand::value, 1);
    echoing.hear(SensorCommand::value, 1);
    echoing.hear(SensorCommand::value, 1, {0, 0});
    echoing.ask(SensorCommand::discover, 2);
    echoing.hear(SensorCommand::discover, 2);
    EXPECT_EQ(echoing.outcomes(), (Outcomes{kAnswered, SensorOutcome::cut}));
}

}  // namespace
}  // namespace tribus::sensor_conversation_test
