#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/sensor_wire.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"

/// Cost of one disturbed byte on a sensor bus, at every place and of every kind.
namespace tribus::ibus_sensor_damage_test {
namespace {

using namespace std::chrono_literals;

/// Requests and replies, 7.7 ms apart, with a probe, a missed answer, a long value and servo
/// frames.
struct Traffic {
    Wire wire;
    std::vector<Bytes> frames;
};

void add(Traffic& traffic, const Bytes& frame) {
    traffic.wire.add(frame);
    traffic.frames.push_back(frame);
}

Traffic traffic() {
    const std::vector<Bytes> replies{
        kReply,
        {},
        encoded(SensorCommand::value, 1, {0x06, 0xA1, 0x04, 0xA1}),
        encoded(SensorCommand::value, 1, {0x04, 0xA1, 0x04, 0xA1}),
        encoded(SensorCommand::value, 1, {0x20, 0x40}),
        encoded(SensorCommand::value, 1, {0x12, 0xA2, 0x20, 0x40}),
        kReply,
    };
    Traffic traffic;
    for (std::size_t slot = 0; slot < replies.size(); ++slot) {
        add(traffic, kRequest);
        if (!replies[slot].empty()) {
            traffic.wire.pause(620us);
            add(traffic, replies[slot]);
        }
        traffic.wire.pause(5ms);
    }
    add(traffic, kProbe);
    traffic.wire.pause(5ms);
    add(traffic, kRequest);
    return traffic;
}

TEST(SensorFrameParser, FindsAllOfUndisturbedTraffic) {
    const Traffic all = traffic();
    EXPECT_EQ(all.wire.frames(), all.frames);
}

bool is_sent_without(const std::vector<Bytes>& sent, std::size_t from, std::size_t lost,
                     const std::vector<Bytes>& found) {
    std::vector<Bytes> rest = sent;
    const auto first = rest.begin() + static_cast<std::ptrdiff_t>(from);
    rest.erase(first, first + static_cast<std::ptrdiff_t>(lost));
    return rest == found;
}

/// Returns whether at most one frame is missing, or two neighbours that are a request and its
/// answer, and no frame was invented.
testing::AssertionResult lost_at_most_one_exchange(const std::vector<Bytes>& sent,
                                                   const std::vector<Bytes>& found) {
    const std::size_t lost = sent.size() - std::min(found.size(), sent.size());
    for (std::size_t from = 0; lost <= 2 && from + lost <= sent.size(); ++from) {
        const bool exchange = lost < 2 || (sent[from].size() == kSensorRequestBytes &&
                                           sent[from + 1].size() > kSensorRequestBytes);
        if (exchange && is_sent_without(sent, from, lost, found)) {
            return testing::AssertionSuccess();
        }
    }
    return testing::AssertionFailure() << found.size() << " frames of " << sent.size();
}

TEST(SensorFrameParser, AByteThatIsLostCostsOneExchange) {
    const Traffic all = traffic();
    for (std::size_t at = 0; at < all.wire.size(); ++at) {
        Wire wire = all.wire;
        wire.lose(at);
        EXPECT_TRUE(lost_at_most_one_exchange(all.frames, wire.frames())) << "byte " << at;
    }
}

TEST(SensorFrameParser, AByteThatIsFlippedCostsOneExchange) {
    const Traffic all = traffic();
    for (std::size_t at = 0; at < all.wire.size(); ++at) {
        for (unsigned bits = 1; bits < 256; ++bits) {
            Wire wire = all.wire;
            wire.flip(at, static_cast<std::uint8_t>(bits));
            EXPECT_TRUE(lost_at_most_one_exchange(all.frames, wire.frames()))
                << "byte " << at << ", bits " << bits;
        }
    }
}

TEST(SensorFrameParser, AByteThatIsAddedCostsOneExchange) {
    const Traffic all = traffic();
    for (std::size_t at = 0; at < all.wire.size(); ++at) {
        for (unsigned byte = 0; byte < 256; ++byte) {
            Wire wire = all.wire;
            wire.insert(at, static_cast<std::uint8_t>(byte));
            EXPECT_TRUE(lost_at_most_one_exchange(all.frames, wire.frames()))
                << "before byte " << at << ", " << byte;
        }
    }
}

}  // namespace
}  // namespace tribus::ibus_sensor_damage_test
