#include "app/mqtt/outbox.h"

#include <chrono>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

/// Messages that wait for the broker, and the order in which they go.
namespace tribus::mqtt::outbox_test {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

constexpr Instant kNow{100s};

Event event(const std::string& text, Instant at = kNow) {
    return {.type = "input", .name = "receiver", .now = "x", .text = text, .at = at};
}

class OutboxTest : public testing::Test {
  protected:
    Json sent(Instant now = kNow) {
        last_ = outbox_.next(now);
        return last_ ? Json::parse(last_->payload, nullptr, false) : Json();
    }
    const Message& last() const { return *last_; }
    bool empty() { return !outbox_.next(kNow).has_value(); }

    Outbox outbox_{"s", {.events = 3, .under_way = 2}};

  private:
    std::optional<Message> last_;
};

TEST_F(OutboxTest, SendsNothingWithoutABroker) {
    outbox_.retain("a", "online");
    outbox_.add("e", event("1"));
    EXPECT_TRUE(empty());
}

TEST_F(OutboxTest, SendsWhatIsRetainedThenEventsThenTheNewestStatus) {
    outbox_.connected();
    outbox_.tell("s", "1");
    outbox_.tell("s", "2");
    outbox_.add("e", event("lost"));
    outbox_.retain("a", "online");
    EXPECT_EQ(outbox_.next(kNow)->payload, "online");
    EXPECT_EQ(sent()["text"], "lost");
    EXPECT_EQ(last().quality, 1);
    EXPECT_FALSE(last().retained);
    const auto status = outbox_.next(kNow);
    EXPECT_EQ(status->payload, "2");
    EXPECT_EQ(status->quality, 0);
    EXPECT_FALSE(status->retained);
    EXPECT_TRUE(empty());
}

TEST_F(OutboxTest, DropsAStatusFromBeforeTheBrokerCame) {
    outbox_.tell("s", "old");
    outbox_.connected();
    EXPECT_TRUE(empty());
    outbox_.tell("s", "new");
    outbox_.disconnected();
    outbox_.connected();
    EXPECT_TRUE(empty());
}

TEST_F(OutboxTest, RetainsOnlyWhatChangedAndAllOfItForANewConnection) {
    outbox_.connected();
    outbox_.retain("a", "online");
    EXPECT_TRUE(outbox_.next(kNow)->retained);
    outbox_.retain("a", "online");
    EXPECT_TRUE(empty());
    outbox_.retain("a", "offline");
    EXPECT_EQ(outbox_.next(kNow)->payload, "offline");
    outbox_.disconnected();
    outbox_.connected();
    EXPECT_EQ(outbox_.next(kNow)->payload, "offline");
}

TEST_F(OutboxTest, RetainsAgainWhatIsBelowATopic) {
    outbox_.connected();
    outbox_.retain("homeassistant/device/x/config", "{}");
    outbox_.retain("tribus/a", "online");
    EXPECT_TRUE(outbox_.next(kNow) && outbox_.next(kNow) && empty());
    outbox_.retain_again("homeassistant/device/");
    EXPECT_EQ(outbox_.next(kNow)->topic, "homeassistant/device/x/config");
    EXPECT_TRUE(empty());
}

TEST_F(OutboxTest, KeepsEventsWhileTheBrokerIsAwayAndMarksThemLate) {
    outbox_.add("e", event("1", kNow - 30s));
    outbox_.connected();
    outbox_.add("e", event("2"));
    EXPECT_EQ(sent()["text"], "1");
    const Json first = Json::parse(last().payload);
    EXPECT_EQ(first["late"], true);
    EXPECT_EQ(first["age_s"], 30.0);
    EXPECT_EQ(first["id"], "s-1");
    EXPECT_EQ(sent()["late"], false);
}

TEST_F(OutboxTest, SendsAnEventOnceOnlyIfItIsAcknowledged) {
    outbox_.connected();
    outbox_.add("e", event("1"));
    outbox_.add("e", event("2"));
    EXPECT_EQ(sent()["text"], "1");
    outbox_.acknowledged(last().event);
    EXPECT_EQ(sent()["text"], "2");
    outbox_.disconnected();
    outbox_.connected();
    const Json again = sent();
    EXPECT_EQ(again["text"], "2");
    EXPECT_EQ(again["id"], "s-2") << "a reader that got it twice knows by this";
    EXPECT_EQ(again["late"], true);
    outbox_.acknowledged(last().event);
    EXPECT_TRUE(empty());
    EXPECT_EQ(outbox_.waiting_events(), 0U);
}

TEST_F(OutboxTest, HasFewEventsUnderWay) {
    outbox_.connected();
    for (const char* text : {"1", "2", "3"}) {
        outbox_.add("e", event(text));
    }
    EXPECT_EQ(sent()["text"], "1");
    const std::uint64_t first = last().event;
    EXPECT_EQ(sent()["text"], "2");
    EXPECT_TRUE(empty());
    outbox_.acknowledged(first);
    EXPECT_EQ(sent()["text"], "3");
}

TEST_F(OutboxTest, LosesTheOldestEventsWhenItIsFullAndSaysHowMany) {
    for (int i = 1; i <= 5; ++i) {
        outbox_.add("e", event(std::to_string(i)));
    }
    EXPECT_EQ(outbox_.waiting_events(), 3U);
    outbox_.connected();
    const Json oldest = sent();
    EXPECT_EQ(oldest["text"], "3");
    EXPECT_EQ(oldest["lost_before"], 2);
    EXPECT_FALSE(sent().contains("lost_before"));
}

}  // namespace
}  // namespace tribus::mqtt::outbox_test
