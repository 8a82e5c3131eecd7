#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "pipelines/engine/engine.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/unit/pipelines/engine/engine_bench.h"
#include "transports/codecs/mavlink/mavlink.h"

/// An output to an autopilot: what it says while it holds, at its end, and after a reload.
namespace tribus::test::engine_mavlink_test {
namespace {

using namespace std::chrono_literals;
using serial::at;
using serial::ibus_input;
using serial::us;

constexpr std::uint8_t kOverrideId = 70;
/// "Flags" of RADIO_RC_CHANNELS.
constexpr unsigned kFailsafe = 1;
constexpr unsigned kOutdated = 2;

OutputSettings autopilot(const MavlinkEncoder::Settings& settings, Duration period = 20ms) {
    return {.name = "drone",
            .encoder = std::make_unique<MavlinkEncoder>(settings),
            .schedule = {.kind = ScheduleKind::grid, .period = period},
            .selection = {.inputs = {0}},
            .channels = {},
            .failsafe = {.hold = 300ms, .action = FailsafeAction::silence}};
}

struct Message {
    Instant at;
    std::vector<std::uint8_t> bytes;
    std::uint8_t id() const { return bytes.at(7); }
    std::uint8_t target() const { return bytes.at(10 + 16); }
};

class AutopilotBench final : public StationObserver {
  public:
    explicit AutopilotBench(OutputSettings output, Duration timeout = 100ms)
        : timeout_(timeout),
          engine_(engine_with(std::move(output))),
          loop_(*engine_, *this, Instant{}) {}

    void wrote(Station /*station*/, Instant when, const Transmission& sent) override {
        const auto bytes = sent.bytes();
        sent_.push_back({when, {bytes.begin(), bytes.end()}});
    }
    void steer(Instant from, Instant until) {
        for (Instant when = from; when < until; when += 8ms) {
            ChannelFrame frame;
            frame.set(0, us(1600));
            std::array<std::uint8_t, kLongestSerialFrame> wire{};
            const std::size_t length = IbusEncoder(14).write(frame, wire, Instant{});
            loop_.receive(input_station(0), std::span(wire).first(length), when);
        }
    }
    /// What was sent since the call before.
    std::vector<Message> sent_until(Instant until) {
        loop_.run_until(until);
        return std::exchange(sent_, {});
    }
    std::vector<Message> sent_at_end(Instant when) {
        loop_.end(when);
        return std::exchange(sent_, {});
    }
    /// A reload gives the output other settings.
    void reload(OutputSettings output, Instant when) {
        auto next = engine_with(std::move(output));
        const std::vector<InputCarry> inputs{{.from = 0, .same_channels = true}};
        next->start(when);
        next->continue_from(*engine_,
                            {.inputs = inputs,
                             .outputs = {{.from = 0, .same_channels = true, .same_failsafe = true}},
                             .nodes = {}},
                            when);
        loop_.go_on_with(*next, nullptr, when);
        engine_ = std::move(next);
    }

  private:
    std::unique_ptr<Engine> engine_with(OutputSettings output) const {
        InputSettings input = ibus_input();
        input.supervision.timeout = timeout_;
        return std::make_unique<Engine>(serial::list(std::move(input)),
                                        serial::list(std::move(output)));
    }

    Duration timeout_;
    std::unique_ptr<Engine> engine_;
    std::vector<Message> sent_;  ///< before `loop_`, which writes at once
    VirtualLoop loop_;
};

const MavlinkEncoder::Settings kOverrides{
    .message = MavlinkChannels::rc_channels_override, .channels = 4, .releases = true};

std::size_t overrides_to(const std::vector<Message>& messages, std::uint8_t target) {
    return static_cast<std::size_t>(std::ranges::count_if(messages, [&](const Message& message) {
        return message.id() == kOverrideId && message.target() == target;
    }));
}

TEST(EngineMavlink, HeldValuesAreMarkedWithWhatArduPilotReads) {
    AutopilotBench bench(autopilot({.channels = 4}));
    const auto flags_of = [](const Message& message) { return message.bytes.at(10 + 4); };
    bench.steer(at(0ms), at(1s));
    const auto control = bench.sent_until(at(1s));
    ASSERT_GT(control.size(), 20U);
    EXPECT_EQ(flags_of(control.back()), 0U);
    // The input is lost 100 ms after its last frame.
    bench.sent_until(at(1120ms));
    const auto held = bench.sent_until(at(1380ms));
    ASSERT_EQ(held.size(), 13U);
    for (const Message& message : held) {
        EXPECT_EQ(flags_of(message), kFailsafe | kOutdated);
    }
    EXPECT_TRUE(bench.sent_until(at(2s)).size() <= 1U);
}

TEST(EngineMavlink, ChannelsAreGivenBackTenTimesAtTheEndAndWithinASecond) {
    for (const auto& [period, times] :
         {std::pair{20ms, 10U}, std::pair{50ms, 10U}, std::pair{250ms, 4U}}) {
        AutopilotBench bench(autopilot(kOverrides, period), 600ms);
        bench.steer(at(0ms), at(2s));
        bench.sent_until(at(2001ms));
        const auto last = bench.sent_at_end(at(2001ms));
        ASSERT_EQ(last.size(), times) << period.count();
        EXPECT_EQ(overrides_to(last, 1), times);
        EXPECT_LT(last.back().at, at(3001ms));
    }
}

TEST(EngineMavlink, ChannelsAreGivenBackAtTheEndWhateverTheFailsafeSends) {
    for (const FailsafeAction action : {FailsafeAction::preset, FailsafeAction::hold}) {
        OutputSettings output = autopilot(kOverrides);
        output.failsafe.action = action;
        output.failsafe.presets.fill(us(1500));
        AutopilotBench bench(std::move(output), 600ms);
        bench.steer(at(0ms), at(2s));
        bench.sent_until(at(2001ms));
        const auto last = bench.sent_at_end(at(2001ms));
        ASSERT_EQ(last.size(), 10U);
        for (const Message& message : last) {
            EXPECT_EQ(message.id(), kOverrideId);
            EXPECT_EQ(message.bytes.at(10), 0U) << "0 gives channel 1 back";
            EXPECT_EQ(message.bytes.at(11), 0U);
        }
    }
}

TEST(EngineMavlink, AReloadToAnotherTargetGivesTheChannelsOfTheOldOneBack) {
    AutopilotBench bench(autopilot(kOverrides));
    bench.steer(at(0ms), at(1s));
    bench.sent_until(at(1s));
    MavlinkEncoder::Settings other = kOverrides;
    other.target = 2;
    bench.reload(autopilot(other), at(1s));
    bench.steer(at(1001ms), at(1500ms));
    const auto sent = bench.sent_until(at(1500ms));
    EXPECT_EQ(overrides_to(sent, 1), 10U);
    EXPECT_EQ(overrides_to(sent, 2), sent.size() - 10);
    EXPECT_GE(sent.size(), 20U);
}

}  // namespace
}  // namespace tribus::test::engine_mavlink_test
