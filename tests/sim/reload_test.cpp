#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <string>
#include <vector>

#include "tests/sim/reload_run.h"
#include "tests/support/can_snapshots.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/sbus/sbus.h"

/// A new configuration replaces the running one; outputs are compared frame by frame.
namespace tribus::test::reload_test {
namespace {

using namespace std::chrono_literals;

constexpr Duration kInterval = 7700us;

Instant at(Duration since_start) {
    return Instant(since_start);
}

constexpr const char* kReceiver = R"([input.receiver]
protocol = "ibus"
device = "/dev/ttyA"
timeout = "100ms"
)";

constexpr const char* kOthers = R"([input.another]
protocol = "sbus"
device = "/dev/ttyX"
[output.another]
protocol = "ibus"
device = "/dev/ttyY"
[pipeline.another]
from = "another"
to = "another"
)";

/// Adds an unrelated input and output before or after the job, so that a reload changes the index
/// of every part.
std::string with_others(const std::string& job, bool in_front) {
    return in_front ? kOthers + job : job + kOthers;
}

std::string sbus_job(const std::string& channels = "", const std::string& failsafe = "") {
    return std::string(kReceiver) + R"([output.servos]
protocol = "sbus"
device = "/dev/ttyB"
period = "9ms"
[pipeline.main]
from = "receiver"
to = "servos"
[pipeline.main.channels]
)" + channels +
           "\n[pipeline.main.failsafe]\npower_on = \"0s\"\n" + failsafe + "\n";
}

std::vector<std::uint8_t> ibus_frame(int first_us, int second_us = 1500) {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < 14; ++channel) {
        frame.set(channel, Pulse::from_microseconds(1500));
    }
    frame.set(0, Pulse::from_microseconds(first_us));
    frame.set(1, Pulse::from_microseconds(second_us));
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = IbusEncoder(14).write(frame, wire, Instant{});
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}

/// Sends a moving stick from `from` to `until`.
void sticks(ReloadRun& run, Instant from, Instant until, const std::string& input = "receiver") {
    for (Instant when = from; when < until; when += kInterval) {
        const auto number = static_cast<int>((when - Instant{}) / kInterval);
        run.receive(input, ibus_frame(1000 + number % 997), when);
    }
}

SbusFrame sbus_of(const Said& said) {
    return parse_sbus(std::span(said.bytes).first<kSbusFrameLength>());
}

/// Returns the latest frame at or before `when`.
SbusFrame at_time(ReloadRun& run, Instant when, const std::string& output = "servos") {
    run.run_until(when + 1ns);
    return run.said(output).empty() ? SbusFrame{} : sbus_of(run.said(output).back());
}

std::uint16_t raw_of(int microseconds) {
    return static_cast<std::uint16_t>((microseconds - 880) * 8 / 5);
}

/// How an output sends the channels; `name` is the protocol.
struct Target {
    const char* name;
    const char* output;
};

class Unchanged : public testing::TestWithParam<Target> {
  protected:
    static std::string job(const char* schedule) {
        return std::string(kReceiver) + "[output.servos]\n" + GetParam().output + schedule +
               "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
               "[pipeline.main.channels]\n2 = { from = 1, slew = \"900us/s\" }\n";
    }
    /// Sends good frames, a loss that is bridged, a loss that is not, and a recovery; with a reload
    /// every 41 ms or without reloads.
    static std::vector<Said> run(const char* schedule, bool reloads) {
        ReloadRun run(with_others(job(schedule), false));
        const std::array runs{std::pair(at(5ms), at(600ms)), std::pair(at(800ms), at(1100ms)),
                              std::pair(at(1900ms), at(3000ms))};
        Instant next_reload = at(reloads ? 41ms : 1h);
        bool in_front = false;
        const auto reload_until = [&](Instant until) {
            for (; next_reload < until; next_reload += 41ms) {
                in_front = !in_front;
                run.reload(with_others(job(schedule), in_front), next_reload);
            }
        };
        for (const auto& [from, until] : runs) {
            for (Instant when = from; when < until; when += kInterval) {
                const auto number = static_cast<int>((when - Instant{}) / kInterval);
                const auto frame = ibus_frame(1000 + number * 7 % 997);
                // The frame comes in two halves: a reload must not lose what is in the decoder.
                reload_until(when);
                run.receive("receiver", std::span(frame).first(11), when);
                reload_until(when + 1ms);
                run.receive("receiver", std::span(frame).subspan(11), when + 1ms);
            }
        }
        reload_until(at(4s));
        run.run_until(at(4s));
        EXPECT_EQ(run.allocations(), 0U);
        std::vector<Said> all = run.said("servos");
        all.insert(all.end(), run.said("node 0").begin(), run.said("node 0").end());
        return all;
    }
};

TEST_P(Unchanged, PathSaysWhatItSaysWithoutReloadsFrameByFrame) {
    for (const char* schedule :
         {"", "schedule = \"grid\"\n", "schedule = \"grid\"\nphase = \"locked\"\n"}) {
        const auto expected = run(schedule, false);
        const auto said = run(schedule, true);
        EXPECT_GT(expected.size(), 100U);
        ASSERT_EQ(said.size(), expected.size()) << schedule;
        for (std::size_t i = 0; i < said.size(); ++i) {
            ASSERT_EQ(said[i], expected[i])
                << schedule << "frame " << i << " at " << expected[i].at.time_since_epoch().count();
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    Protocols, Unchanged,
    testing::Values(
        Target{"sbus", "protocol = \"sbus\"\ndevice = \"/dev/ttyB\"\nperiod = \"9ms\"\n"},
        Target{"ibus", "protocol = \"ibus\"\ndevice = \"/dev/ttyB\"\nperiod = \"9ms\"\n"},
        Target{"can", "protocol = \"can\"\ninterface = \"can0\"\nid = 0x300\n"},
        Target{"can_fd", "protocol = \"can\"\ninterface = \"can0\"\nid = 0x300\nfd = true\n"},
        Target{"dronecan", "protocol = \"dronecan\"\ninterface = \"can0\"\nnode_id = 42\n"}),
    [](const testing::TestParamInfo<Target>& target) { return target.param.name; });

TEST(Reload, TakesANewMapWithTheNextFrameAndWithoutFailsafe) {
    ReloadRun run(sbus_job());
    for (Instant when = at(5ms); when < at(1s); when += kInterval) {
        if (when > at(500ms) && when < at(500ms) + kInterval) {
            run.reload(sbus_job("1 = { from = 1, reverse = true }"), at(500ms));
        }
        run.receive("receiver", ibus_frame(1100), when);
    }
    for (const Said& said : run.said("servos")) {
        if (said.at > at(20ms)) {
            const SbusFrame frame = sbus_of(said);
            EXPECT_FALSE(frame.failsafe || frame.frame_lost);
            EXPECT_EQ(frame.raw[0], said.at < at(500ms) ? raw_of(1100) : raw_of(1900));
        }
    }
    EXPECT_EQ(run.output("servos").counts().failsafe_entries, 0U);
}

TEST(Reload, BeginsANewSlewWhereTheOutputStands) {
    ReloadRun run(sbus_job());
    for (Instant when = at(5ms); when < at(200ms); when += kInterval) {
        run.receive("receiver", ibus_frame(1000), when);
    }
    run.reload(sbus_job("1 = { from = 1, slew = \"1000us/s\" }"), at(200ms));
    run.receive("receiver", ibus_frame(2000), at(201ms));
    const SbusFrame frame = at_time(run, at(220ms));
    EXPECT_GE(frame.raw[0], raw_of(1000));
    EXPECT_LE(frame.raw[0], raw_of(1040)) << "the output jumped";
}

TEST(Reload, LetsTheTimersOfAFailsafeRunOnAndTakesNewPresets) {
    ReloadRun run(sbus_job("", "hold = \"300ms\"\npreset = { 1 = 1200, other = 1500 }"));
    sticks(run, at(5ms), at(200ms));
    // The input is lost at about 300 ms and held to about 600 ms.
    run.reload(sbus_job("", "hold = \"300ms\"\npreset = { 1 = 1300, other = 1500 }"), at(450ms));
    EXPECT_TRUE(at_time(run, at(560ms)).frame_lost);
    EXPECT_FALSE(at_time(run, at(560ms)).failsafe) << "the reload ended the hold";
    EXPECT_TRUE(at_time(run, at(620ms)).failsafe) << "the reload started the hold again";
    EXPECT_EQ(at_time(run, at(620ms)).raw[0], raw_of(1300));
    EXPECT_EQ(run.output("servos").counts().failsafe_entries, 1U);
}

TEST(Reload, AsksForTheRestOfARecoveryNotForAllOfIt) {
    ReloadRun run(sbus_job("", "recover = \"500ms\""));
    sticks(run, at(5ms), at(200ms));
    sticks(run, at(1000ms), at(1300ms));
    run.reload(sbus_job("2 = 3", "recover = \"500ms\""), at(1300ms));
    sticks(run, at(1301ms), at(1700ms));
    const auto& said = run.said("servos");
    const auto back = std::ranges::find_if(
        said, [](const Said& one) { return one.at > at(1000ms) && !sbus_of(one).failsafe; });
    ASSERT_NE(back, said.end());
    EXPECT_GE(back->at, at(1500ms));
    EXPECT_LE(back->at, at(1520ms));
}

TEST(Reload, CountsAShorterTimeoutAtOnce) {
    std::string patient = sbus_job();
    patient.replace(patient.find("\"100ms\""), 7, "\"5s\"");
    ReloadRun run(patient);
    sticks(run, at(5ms), at(200ms));
    run.reload(sbus_job(), at(250ms));
    EXPECT_FALSE(at_time(run, at(280ms)).frame_lost);
    EXPECT_TRUE(at_time(run, at(320ms)).frame_lost);
}

TEST(Reload, TakesAShorterPeriodFromTheNextFrameOn) {
    std::string slow = sbus_job();
    slow.replace(slow.find("\"9ms\""), 5, "\"1s\"");
    slow.replace(slow.find("timeout = \"100ms\""), 17, "timeout = \"5s\"");
    ReloadRun run(slow);
    sticks(run, at(5ms), at(3s));
    run.reload(sbus_job(), at(3s));
    run.run_until(at(3050ms));
    const auto& said = run.said("servos");
    EXPECT_GE(std::ranges::count_if(said, [](const Said& one) { return one.at >= at(3s); }), 5);
}

constexpr const char* kBackup = R"([input.backup]
protocol = "ibus"
device = "/dev/ttyC"
timeout = "100ms"
)";

std::string with_inputs(const std::string& inputs, const std::string& from) {
    std::string text = sbus_job("", "hold = \"300ms\"");
    text.replace(0, std::string(kReceiver).size(), inputs);
    text.replace(text.find("from = \"receiver\""), 17, "from = " + from);
    return text;
}

TEST(Reload, ThatRemovesTheInputInControlHoldsAndThenFailsSafeAsAfterALoss) {
    ReloadRun run(sbus_job("", "hold = \"300ms\""));
    sticks(run, at(5ms), at(500ms));
    const auto before = at_time(run, at(500ms));
    run.reload(with_inputs(kBackup, "\"backup\""), at(500ms));
    const SbusFrame held = at_time(run, at(700ms));
    EXPECT_TRUE(held.frame_lost);
    EXPECT_FALSE(held.failsafe);
    EXPECT_EQ(held.raw[0], before.raw[0]);
    EXPECT_TRUE(at_time(run, at(820ms)).failsafe);
}

TEST(Reload, ThatRemovesTheInputInControlPassesItToAHealthyBackupAtOnce) {
    const std::string both = std::string(kReceiver) + kBackup;
    ReloadRun run(with_inputs(both, "[\"receiver\", \"backup\"]"));
    for (Instant when = at(5ms); when < at(500ms); when += kInterval) {
        run.receive("receiver", ibus_frame(1100), when);
        run.receive("backup", ibus_frame(1700), when + 1ms);
    }
    EXPECT_EQ(at_time(run, at(500ms)).raw[0], raw_of(1100));
    run.reload(with_inputs(kBackup, "\"backup\""), at(500ms));
    for (const Duration since : {520ms, 550ms}) {
        const SbusFrame frame = at_time(run, at(since));
        EXPECT_FALSE(frame.failsafe || frame.frame_lost);
        EXPECT_EQ(frame.raw[0], raw_of(1700));
    }
    EXPECT_EQ(run.output("servos").counts().changeovers, 1U);
}

TEST(Reload, ThatAddsAPreferredInputLeavesControlWhereItIsUntilThatHasAFrame) {
    const std::string both = std::string(kBackup) + kReceiver;
    ReloadRun run(sbus_job());
    for (Instant when = at(5ms); when < at(500ms); when += kInterval) {
        run.receive("receiver", ibus_frame(1100), when);
    }
    run.reload(with_inputs(both, "[\"backup\", \"receiver\"]"), at(500ms));
    const SbusFrame frame = at_time(run, at(520ms));
    EXPECT_FALSE(frame.failsafe || frame.frame_lost);
    EXPECT_EQ(frame.raw[0], raw_of(1100));
    run.receive("backup", ibus_frame(1700), at(525ms));
    EXPECT_EQ(at_time(run, at(545ms)).raw[0], raw_of(1700));
}

TEST(Reload, ThatRemovesAnOutputLetsItSayItsLastFramesWhileTheOthersGoOn) {
    const std::string extra = R"([output.extra]
protocol = "sbus"
device = "/dev/ttyD"
[pipeline.extra]
from = "receiver"
to = "extra"
[pipeline.extra.failsafe]
power_on = "0s"
)";
    ReloadRun run(sbus_job() + extra);
    ReloadRun without(sbus_job());
    sticks(run, at(5ms), at(500ms));
    sticks(without, at(5ms), at(500ms));
    run.reload(sbus_job(), at(500ms));
    run.run_until(at(2s));
    without.run_until(at(2s));
    int last_frames = 0;
    for (const Said& said : run.said("extra")) {
        EXPECT_EQ(sbus_of(said).failsafe, said.at >= at(500ms) || said.at < at(5ms));
        last_frames += said.at >= at(500ms) ? 1 : 0;
    }
    EXPECT_GE(last_frames, 2);
    EXPECT_LT(run.said("extra").back().at, at(560ms));
    EXPECT_EQ(run.said("servos"), without.said("servos"));
}

TEST(Reload, KeepsAPortThatWasOnlyRenamed) {
    std::string renamed = sbus_job();
    for (std::size_t place = 0; (place = renamed.find("receiver")) != std::string::npos;) {
        renamed.replace(place, 8, "rx");
    }
    ReloadRun run(sbus_job());
    sticks(run, at(5ms), at(500ms));
    const std::uint64_t frames = run.input("receiver").counts().frames;
    run.reload(renamed, at(500ms));
    EXPECT_EQ(run.input("rx").counts().frames, frames);
    EXPECT_FALSE(at_time(run, at(550ms)).frame_lost);
}

TEST(Reload, LetsAChangedInputStartAsNeverSeen) {
    std::string moved = sbus_job();
    moved.replace(moved.find("/dev/ttyA"), 9, "/dev/ttyZ");
    ReloadRun run(sbus_job());
    sticks(run, at(5ms), at(500ms));
    run.reload(moved, at(500ms));
    EXPECT_FALSE(run.input("receiver").link().ever_good());
    EXPECT_EQ(run.input("receiver").counts().bytes, 0U);
    EXPECT_TRUE(at_time(run, at(520ms)).frame_lost);
}

/// The native format proves its counter again after each doubt: a decoder that started again would
/// lose two snapshots.
TEST(Reload, KeepsTheProofOfACanInputAndHalfASnapshot) {
    const std::string job = R"([input.receiver]
protocol = "can"
interface = "can0"
[output.servos]
protocol = "sbus"
device = "/dev/ttyB"
[pipeline.main]
from = "receiver"
to = "servos"
)";
    ReloadRun run(with_others(job, false));
    CanChannelsEncoder sender;
    bool in_front = false;
    for (int number = 1; number <= 100; ++number) {
        const Instant when = at(number * 10ms);
        const CanFrames frames = can_frames(sender, numbered_snapshot(number, when), when);
        run.receive("receiver", frames[0], when);
        in_front = !in_front;
        run.reload(with_others(job, in_front), when + 100us);
        for (std::size_t i = 1; i < frames.size(); ++i) {
            run.receive("receiver", frames[i], when + 200us);
        }
    }
    EXPECT_GE(run.input("receiver").counts().frames, 98U);
    EXPECT_TRUE(std::ranges::all_of(run.input("receiver").decoder().rejected(),
                                    [](const NamedCount& cause) { return cause.count <= 2; }));
    EXPECT_EQ(run.allocations(), 0U);
}

}  // namespace
}  // namespace tribus::test::reload_test
