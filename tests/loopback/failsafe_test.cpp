#include <csignal>

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"

namespace tribus::test::failsafe_test {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kTimeout{200};
constexpr milliseconds kHold{250};
constexpr milliseconds kRecover{300};
constexpr milliseconds kPeriod{7};

std::string loss_config() {
    return main_job("timeout = \"200ms\"", "", R"([pipeline.main.failsafe]
hold    = "250ms"
preset  = { 3 = 988, other = 1500 }
recover = "300ms")");
}

SbusSight presets() {
    Sticks sticks(18, 1500);
    sticks[2] = 988;
    return sbus_sight_of(sticks);
}

enum class Phase { control, holding, failsafe };

Phase phase_of(const SbusSight& sight) {
    return sight.failsafe ? Phase::failsafe : sight.frame_lost ? Phase::holding : Phase::control;
}

class Failsafe : public Loopback {
  protected:
    /// Sends until the servos are in control, and a little longer.
    void gain_control() {
        int good = 0;
        ASSERT_TRUE(eventually([&] {
            repeater_.send_if_due();
            for (const SbusSight& sight : servos_.listen()) {
                good += sight.good() ? 1 : 0;
            }
            return good >= 10;
        }));
    }
    /// Returns the servos' frames until `enough` of them were seen in this phase.
    std::vector<SbusSight> listen_until(Phase phase, int enough, bool sending = false) {
        std::vector<SbusSight> seen;
        int count = 0;
        EXPECT_TRUE(eventually([&] {
            if (sending) {
                repeater_.send_if_due();
            }
            for (const SbusSight& sight : servos_.listen()) {
                seen.push_back(sight);
                count += phase_of(sight) == phase ? 1 : 0;
            }
            return count >= enough;
        }));
        return seen;
    }

    FarEnd& receiver_ = device("receiver");
    FarEnd& servo_wire_ = device("servos");
    ServoBank servos_{servo_wire_};
    Sticks sticks_ = sticks_with_first(1250);
    Repeater repeater_{receiver_, ibus_bytes(sticks_)};
};

TEST_F(Failsafe, StandsBeforeTheFirstFrame) {
    Program& program = run(write_config(loss_config()));
    const std::vector<SbusSight> seen = listen_until(Phase::failsafe, 20);
    for (const SbusSight& sight : seen) {
        EXPECT_TRUE(sight.failsafe && sight.frame_lost);
        EXPECT_TRUE(same_channels(sight, presets()));
    }
    expect_clean_end(program);
}

TEST_F(Failsafe, FollowsALossByMarkedFramesThenPresets) {
    Program& program = run(write_config(loss_config()));
    gain_control();
    const Clock::time_point last_sent = repeater_.latest();
    const std::vector<SbusSight> seen = listen_until(Phase::failsafe, 10);

    EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end(), [](const auto& a, const auto& b) {
        return phase_of(a) < phase_of(b);
    })) << "the order is not control, frame-lost, failsafe";
    const auto first = [&](Phase phase) {
        return std::find_if(seen.begin(), seen.end(),
                            [&](const SbusSight& sight) { return phase_of(sight) == phase; });
    };
    const auto holding = first(Phase::holding);
    const auto failsafe = first(Phase::failsafe);
    ASSERT_TRUE(holding != seen.end() && failsafe != seen.end());
    // Never earlier than configured. A frame counts for the period after it.
    EXPECT_GE(holding->seen - last_sent, kTimeout - kPeriod);
    EXPECT_GE(failsafe->seen - last_sent, kTimeout + kHold - kPeriod);
    // No more marked or unmarked frames than fit into the time. This counts the program's own pace,
    // not this machine's. Unmarked frames may have waited for as long as the receiver may pause.
    EXPECT_LE(holding - seen.begin(), 2 * kTimeout / kPeriod + 2);
    EXPECT_LE(failsafe - holding, kHold / kPeriod + 2);
    EXPECT_TRUE(std::all_of(holding, failsafe, [&](const SbusSight& sight) {
        return same_channels(sight, sbus_sight_of(sticks_));
    })) << "other values than the last ones are held";
    EXPECT_TRUE(std::all_of(failsafe, seen.end(), [&](const SbusSight& sight) {
        return sight.frame_lost && same_channels(sight, presets());
    }));
    EXPECT_TRUE(program.says("input receiver: wire silent"));
    EXPECT_TRUE(program.says("output servos: in failsafe"));
    expect_clean_end(program);
}

TEST_F(Failsafe, ReturnsControlAfterAnUnbrokenRunOfTheRecoverTime) {
    Program& program = run(write_config(loss_config()));
    gain_control();
    listen_until(Phase::failsafe, 1);
    sticks_[0] = 1750;
    repeater_.change(ibus_bytes(sticks_));
    const Clock::time_point back = Clock::now();
    const std::vector<SbusSight> seen = listen_until(Phase::control, 10, true);
    const auto good =
        std::find_if(seen.begin(), seen.end(), [](const SbusSight& sight) { return sight.good(); });
    ASSERT_NE(good, seen.end());
    EXPECT_GE(good->seen - back, kRecover);
    EXPECT_TRUE(std::all_of(seen.begin(), good, [](const SbusSight& sight) {
        return sight.failsafe && same_channels(sight, presets());
    })) << "values other than presets came before control";
    EXPECT_TRUE(same_channels(*good, sbus_sight_of(sticks_)));
    EXPECT_TRUE(program.says("output servos: under control", 2));
    expect_clean_end(program);
}

TEST_F(Failsafe, SilencesAnOutputThatCannotSayIt) {
    IbusReader reader(device("controller"));
    Program& program = run(write_config(R"(
[input.receiver]
protocol = "ibus"
device   = "@receiver"
timeout  = "200ms"

[output.controller]
protocol = "ibus"
device   = "@controller"

[pipeline.main]
from = "receiver"
to   = "controller"

[pipeline.main.failsafe]
hold    = "100ms"
recover = "100ms"
)"));
    const auto hears = [&] { return !reader.listen().empty(); };
    const auto sends_and_hears = [&] {
        repeater_.send_if_due();
        return hears();
    };
    EXPECT_TRUE(eventually(sends_and_hears));
    EXPECT_TRUE(program.says("output controller: in failsafe"));
    reader.listen();
    Clock::time_point heard = Clock::now();
    EXPECT_TRUE(eventually([&] {
        heard = hears() ? Clock::now() : heard;
        return Clock::now() - heard > milliseconds(500);
    })) << "frames do not stop";
    EXPECT_TRUE(eventually(sends_and_hears)) << "control did not come back";
    expect_clean_end(program);
}

class EndingSignal : public Failsafe, public testing::WithParamInterface<int> {
  protected:
    /// The program ends, and its last frames say failsafe.
    void expect_last_frames(Program& program) {
        std::vector<SbusSight> seen;
        const auto collect = [&] {
            for (const SbusSight& sight : servos_.listen()) {
                seen.push_back(sight);
            }
        };
        const auto start = Clock::now();
        EXPECT_TRUE(eventually([&] {
            repeater_.send_if_due();
            collect();
            return !program.runs();
        }));
        // It waits no longer for a machine that does not let it run.
        const bool had_time = Clock::now() - start < milliseconds(500);
        // What it wrote may still be on its way through the terminal.
        eventually([&] {
            collect();
            return std::ranges::count_if(seen, &SbusSight::failsafe) >= 2;
        });
        EXPECT_EQ(program.end(), 0);
        EXPECT_TRUE(program.says("stopped"));
        const auto first = std::find_if(seen.begin(), seen.end(),
                                        [](const SbusSight& sight) { return sight.failsafe; });
        // One frame may be lost on a wire.
        EXPECT_GE(seen.end() - first, had_time ? 2 : 1);
        EXPECT_TRUE(std::all_of(first, seen.end(), [](const SbusSight& sight) {
            return sight.failsafe && sight.frame_lost && same_channels(sight, presets());
        }));
        EXPECT_EQ(servos_.strays(), 0U);
        expect_no_allocation(program);
    }
};

TEST_P(EndingSignal, LetsTheLastFramesSayFailsafe) {
    Program& program = run(write_config(loss_config()));
    gain_control();
    program.signal(GetParam());
    expect_last_frames(program);
}

TEST_P(EndingSignal, LetsTheLastFramesSayFailsafeThoughItIsStoppedMeanwhile) {
    Program& program = run(write_config(loss_config()));
    gain_control();
    program.signal(GetParam());
    std::this_thread::sleep_for(milliseconds(5));
    program.signal(SIGSTOP);
    // Longer than the last frames take.
    std::this_thread::sleep_for(milliseconds(100));
    program.signal(SIGCONT);
    expect_last_frames(program);
}

INSTANTIATE_TEST_SUITE_P(Signals, EndingSignal, testing::Values(SIGTERM, SIGINT),
                         [](const auto& number) {
                             return std::string(number.param == SIGTERM ? "Terminate" : "CtrlC");
                         });

}  // namespace
}  // namespace tribus::test::failsafe_test
