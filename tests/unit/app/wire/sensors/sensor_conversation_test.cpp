#include "app/wire/sensors/sensor_conversation.h"

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

/// Passes frames with or without times to a conversation and keeps the exchanges.
class SensorBus {
  public:
    explicit SensorBus(bool timed) : timed_(timed) {}
    // Not copied, because the conversation has a reference to it.
    SensorBus(const SensorBus&) = delete;
    SensorBus& operator=(const SensorBus&) = delete;

    void slot() {
        slot_ += 7700us;
        now_ = slot_;
    }
    void feed(SensorCommand command, std::uint8_t address, std::vector<std::uint8_t> data = {}) {
        ReceivedSensorFrame received;
        received.frame.command = command;
        received.frame.address = address;
        received.frame.data_size = static_cast<std::uint8_t>(data.size());
        std::copy(data.begin(), data.end(), received.frame.data.begin());
        if (timed_) {
            received.start = now_;
            received.end = now_ + 370us;
        }
        now_ += 370us + 630us;
        conversation.take(received);
    }
    void ask(SensorCommand command, std::uint8_t address) {
        slot();
        feed(command, address);
    }
    Outcomes outcomes() {
        conversation.finish();
        Outcomes outcomes;
        for (const SensorExchange& exchange : exchanges) {
            outcomes.push_back(exchange.outcome);
        }
        return outcomes;
    }

    std::vector<SensorExchange> exchanges;
    SensorConversation conversation{
        [this](const SensorExchange& exchange) { exchanges.push_back(exchange); }};

  private:
    bool timed_;
    Duration slot_{};
    Duration now_{};
};

class SensorConversationTest : public testing::TestWithParam<bool> {
  protected:
    SensorBus bus{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(TimedOrNot, SensorConversationTest, testing::Bool());

TEST_P(SensorConversationTest, AValueIsPairedWithItsRequest) {
    bus.ask(SensorCommand::value, 1);
    bus.feed(SensorCommand::value, 1, {7, 0});
    ASSERT_EQ(bus.outcomes(), Outcomes{kAnswered});
    EXPECT_EQ(bus.exchanges[0].answer->frame.data[0], 7);
}

TEST_P(SensorConversationTest, ARequestThatIsRepeatedWasMissedAndAskedAgain) {
    bus.ask(SensorCommand::value, 1);
    bus.ask(SensorCommand::value, 1);
    bus.feed(SensorCommand::value, 1, {7, 0});
    ASSERT_EQ(bus.outcomes(), (Outcomes{kMissed, kAnswered}));
    EXPECT_TRUE(bus.exchanges[0].asked_again);
    EXPECT_EQ(bus.conversation.counts().misses_asked_again, 1U);
}

TEST_P(SensorConversationTest, ARequestThatAnotherFollowsWasMissed) {
    bus.ask(SensorCommand::value, 1);
    bus.ask(SensorCommand::value, 2);
    bus.feed(SensorCommand::value, 2, {7, 0});
    ASSERT_EQ(bus.outcomes(), (Outcomes{kMissed, kAnswered}));
    EXPECT_FALSE(bus.exchanges[0].asked_again);
}

TEST_P(SensorConversationTest, AnAnswerOfAnotherAddressIsUnasked) {
    bus.ask(SensorCommand::value, 1);
    bus.feed(SensorCommand::value, 2, {7, 0});
    EXPECT_EQ(bus.outcomes(), (Outcomes{kMissed, SensorOutcome::unasked}));
}

TEST_P(SensorConversationTest, ARequestAtTheEndIsNoMiss) {
    bus.ask(SensorCommand::value, 1);
    EXPECT_EQ(bus.outcomes(), Outcomes{SensorOutcome::cut});
    EXPECT_EQ(bus.conversation.counts().misses, 0U);
}

TEST_P(SensorConversationTest, PowerUpFramesStandAlone) {
    bus.ask(SensorCommand::power_up, 0);
    bus.ask(SensorCommand::power_up, 0);
    EXPECT_EQ(bus.outcomes(), Outcomes(2, SensorOutcome::power_up));
    EXPECT_EQ(bus.conversation.counts().power_up, 2U);
}

TEST_P(SensorConversationTest, DiscoverThatIsHeardTwiceAndThenAskedForItsTypeIsAnswered) {
    bus.ask(SensorCommand::discover, 1);
    bus.feed(SensorCommand::discover, 1);
    bus.ask(SensorCommand::type, 1);
    bus.feed(SensorCommand::type, 1, {3, 2});
    ASSERT_EQ(bus.outcomes(), (Outcomes{kAnswered, kAnswered}));
    EXPECT_EQ(bus.exchanges[1].type->id, 3);
    EXPECT_EQ(bus.exchanges[1].type->size, 2);
}

TEST_P(SensorConversationTest, ASensorsTypeIsKnownFromThenOn) {
    bus.ask(SensorCommand::type, 2);
    bus.feed(SensorCommand::type, 2, {1, 2});
    bus.ask(SensorCommand::value, 2);
    bus.feed(SensorCommand::value, 2, {0, 0});
    bus.ask(SensorCommand::value, 1);
    bus.feed(SensorCommand::value, 1, {0, 0});
    bus.outcomes();
    EXPECT_EQ(bus.exchanges[1].type->id, 1);
    EXPECT_FALSE(bus.exchanges[2].type);
}

// A receiver without sensors sends 81 in every slot.
TEST_P(SensorConversationTest, DiscoverInEverySlotFindsNobody) {
    for (int slot = 0; slot < 5; ++slot) {
        bus.ask(SensorCommand::discover, 1);
    }
    bus.ask(SensorCommand::power_up, 0);
    EXPECT_EQ(bus.outcomes(),
              (Outcomes{kFree, kFree, kFree, kFree, kFree, SensorOutcome::power_up}));
    EXPECT_EQ(bus.conversation.counts().probes, 5U);
    EXPECT_EQ(bus.conversation.counts().requests, 0U);
}

TEST_P(SensorConversationTest, TheLastOfManyDiscoversIsAnsweredIfTheTypeIsAskedFor) {
    for (int slot = 0; slot < 4; ++slot) {
        bus.ask(SensorCommand::discover, 1);
    }
    bus.feed(SensorCommand::discover, 1);
    bus.ask(SensorCommand::type, 1);
    bus.feed(SensorCommand::type, 1, {3, 2});
    EXPECT_EQ(bus.outcomes(), (Outcomes{kFree, kFree, kFree, kAnswered, kAnswered}));
}

TEST_P(SensorConversationTest, AProbeAmongValuesFoundNobody) {
    bus.ask(SensorCommand::discover, 2);
    bus.ask(SensorCommand::value, 1);
    bus.feed(SensorCommand::value, 1, {0, 0});
    EXPECT_EQ(bus.outcomes(), (Outcomes{kFree, kAnswered}));
    EXPECT_EQ(bus.conversation.addresses()[2].probes, 1U);
}

TEST(SensorConversation, ResponseTimeRunsFromTheEndOfTheRequest) {
    SensorBus bus(true);
    bus.ask(SensorCommand::value, 1);
    bus.feed(SensorCommand::value, 1, {0, 0});
    bus.outcomes();
    EXPECT_EQ(bus.exchanges[0].response_time, 630us);
    EXPECT_EQ(bus.conversation.addresses()[1].response_times, std::vector<Duration>{630us});
}

TEST(SensorConversation, ARequestThatIsHeardAgainAtOnceIsAnEcho) {
    SensorBus bus(true);
    bus.ask(SensorCommand::value, 1);
    bus.feed(SensorCommand::value, 1);
    bus.feed(SensorCommand::value, 1, {0, 0});
    ASSERT_EQ(bus.outcomes(), Outcomes{kAnswered});
    EXPECT_EQ(bus.exchanges[0].echoes, 1U);
    EXPECT_EQ(bus.exchanges[0].response_time, 630us);
}

TEST(SensorConversation, DiscoverWithEchoAndAnswerIsHeardThreeTimes) {
    SensorBus bus(true);
    bus.ask(SensorCommand::discover, 1);
    bus.feed(SensorCommand::discover, 1);
    bus.feed(SensorCommand::discover, 1);
    bus.ask(SensorCommand::type, 1);
    ASSERT_EQ(bus.outcomes(), (Outcomes{kAnswered, SensorOutcome::cut}));
    EXPECT_EQ(bus.exchanges[0].echoes, 1U);
}

TEST(SensorConversation, DiscoverThatIsHeardTwiceAndNotFollowedByItsTypeIsAnEcho) {
    SensorBus bus(true);
    bus.ask(SensorCommand::discover, 2);
    bus.feed(SensorCommand::discover, 2);
    bus.ask(SensorCommand::value, 1);
    ASSERT_EQ(bus.outcomes(), (Outcomes{kFree, SensorOutcome::cut}));
    EXPECT_EQ(bus.exchanges[0].echoes, 1U);
}

TEST(SensorConversation, DiscoverTwiceAtTheEndIsAnAnswerUnlessTheRecorderHearsItself) {
    SensorBus plain(true);
    plain.ask(SensorCommand::discover, 2);
    plain.feed(SensorCommand::discover, 2);
    EXPECT_EQ(plain.outcomes(), Outcomes{kAnswered});

    SensorBus echoing(true);
    echoing.ask(SensorCommand::value, 1);
    echoing.feed(SensorCommand::value, 1);
    echoing.feed(SensorCommand::value, 1, {0, 0});
    echoing.ask(SensorCommand::discover, 2);
    echoing.feed(SensorCommand::discover, 2);
    EXPECT_EQ(echoing.outcomes(), (Outcomes{kAnswered, SensorOutcome::cut}));
}

}  // namespace
}  // namespace tribus::sensor_conversation_test
