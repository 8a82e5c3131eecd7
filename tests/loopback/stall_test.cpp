#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <ctime>

#include <gtest/gtest.h>

#include "tests/loopback/witnessed.h"

/// The program is stopped and continued while its senders go on.
namespace tribus::test::stall_test {
namespace {

using namespace std::chrono_literals;

/// With TRIBUS_LONG=1 there are some 360 stalls instead of 23.
int scale() {
    return std::getenv("TRIBUS_LONG") != nullptr ? 16 : 1;
}

class Stall : public Witnessed {
  protected:
    void expect_nothing_stale() {
        for (WitnessedLine& line : lines_) {
            const Testimony& testimony = line.witness().testimony();
            EXPECT_EQ(testimony.too_old, 0U) << to_text(testimony);
            EXPECT_EQ(testimony.never_sent, 0U) << to_text(testimony);
            EXPECT_EQ(testimony.strays, 0U) << to_text(testimony);
        }
    }
    std::uint64_t unmarked() {
        std::uint64_t all = 0;
        for (WitnessedLine& line : lines_) {
            all += line.witness().testimony().unmarked;
        }
        return all;
    }
};

/// A frame may be as old as the input's timeout, and counts for one period.
TEST_F(Stall, LongerThanTheTimeoutGivesNoUnmarkedFrameThatIsOlder) {
    Program& program =
        begin(8, "timeout = \"100ms\"", "recover = \"0ms\"\npower_on = \"0ms\"", 100ms + 7ms);
    for (int stall = 0; stall < 12 * scale(); ++stall) {
        program.signal(SIGSTOP);
        go_on_for(200ms + up_to(300ms));
        program.signal(SIGCONT);
        go_on_for(100ms + up_to(14ms));
        EXPECT_TRUE(all_in_control());
    }
    expect_nothing_stale();
    EXPECT_TRUE(program.says("this program did not run for 0.")) << program.errors();
    expect_clean_end(program);
}

/// More bytes wait than the line buffer of a terminal holds: the kernel delivers the rest a moment
/// after the first part was read.
TEST_F(Stall, GivesNoUnmarkedFrameThatIsOlderThanSeconds) {
    Program& program =
        begin(8, "timeout = \"100ms\"", "recover = \"0ms\"\npower_on = \"0ms\"", 100ms + 7ms);
    for (int stall = 0; stall < 2 * scale(); ++stall) {
        program.signal(SIGSTOP);
        go_on_for(2500ms);
        program.signal(SIGCONT);
        go_on_for(100ms);
        EXPECT_TRUE(all_in_control());
    }
    expect_nothing_stale();
    expect_clean_end(program);
}

TEST_F(Stall, LongerThanTheTimeoutAsksForRecoverAlthoughValuesAreStillHeld) {
    Program& program = begin(2, "timeout = \"100ms\"", "hold = \"5s\"\nrecover = \"400ms\"", 1s);
    program.signal(SIGSTOP);
    go_on_for(300ms);
    const auto back = Clock::now();
    program.signal(SIGCONT);
    ASSERT_TRUE(turn_until([this] { return !lines_[0].witness().in_control(); }));
    ASSERT_TRUE(turn_until([this] { return lines_[0].witness().in_control(); }));
    EXPECT_GE(Clock::now() - back, 400ms);
    expect_clean_end(program);
}

TEST_F(Stall, ShorterThanTheTimeoutIsFollowedByTheNewestFrame) {
    Program& program = begin(8, "timeout = \"5s\"", "recover = \"0ms\"\npower_on = \"0ms\"", 10s);
    for (int stall = 0; stall < 8 * scale(); ++stall) {
        program.signal(SIGSTOP);
        go_on_for(300ms + up_to(14ms));
        for (WitnessedLine& line : lines_) {
            line.witness().want_the_newest();
        }
        // Time that a busy machine may take from a write until a read finds the bytes.
        const timespec pause{.tv_sec = 0, .tv_nsec = 200'000'000};
        ::nanosleep(&pause, nullptr);
        const std::uint64_t enough = unmarked() + 10 * lines_.size();
        program.signal(SIGCONT);
        ASSERT_TRUE(turn_until([&] { return unmarked() >= enough; }));
    }
    for (WitnessedLine& line : lines_) {
        const Testimony& testimony = line.witness().testimony();
        EXPECT_EQ(testimony.overtaken, 0U) << to_text(testimony);
    }
    expect_clean_end(program);
}

/// The waiting bytes may have come at any time since the program was stopped.
TEST_F(Stall, ShorterThanTheTimeoutMakesNothingYoungerThanItIs) {
    Program& program = begin(4, "timeout = \"1s\"",
                             "hold = \"0ms\"\nrecover = \"0ms\"\npower_on = \"0ms\"", 1007ms);
    program.signal(SIGSTOP);
    go_on_for(100ms);
    for (WitnessedLine& line : lines_) {
        line.silence(Clock::now() + 1h);
    }
    go_on_for(600ms);
    program.signal(SIGCONT);
    EXPECT_TRUE(turn_until([this] {
        return std::ranges::none_of(
            lines_, [](WitnessedLine& line) { return line.witness().in_control(); });
    }));
    expect_nothing_stale();
    expect_clean_end(program);
}

TEST_F(Stall, JoinsNoHalfFramesOfBeforeAndBehind) {
    constexpr std::size_t kHalf = 10;
    FarEnd& receiver = device("receiver");
    ServoBank servos(device("servos"));
    Program& program = run(write_config(R"([input.receiver]
protocol = "sbus"
device = "@receiver"
timeout = "100ms"
[output.servos]
protocol = "sbus"
device = "@servos"
period = "7ms"
[pipeline.main]
from = "receiver"
to = "servos"
[pipeline.main.failsafe]
hold = "0ms"
recover = "0ms"
power_on = "0ms"
)"));
    const Bytes before = sbus_bytes(sbus_sight_of(Sticks(16, 1200)));
    const Bytes behind = sbus_bytes(sbus_sight_of(Sticks(16, 1800)));
    Repeater repeater(receiver, before);
    const auto all = [&](bool good) {
        return eventually([&] {
            if (good) {
                repeater.send_if_due();
            }
            const auto seen = servos.listen();
            return !seen.empty() && seen.back().good() == good;
        });
    };
    ASSERT_TRUE(all(true)) << program.errors();
    constexpr timespec kStep{.tv_sec = 0, .tv_nsec = 20'000'000};
    ::nanosleep(&kStep, nullptr);
    receiver.send(Bytes(before.begin(), before.begin() + kHalf));
    ::nanosleep(&kStep, nullptr);
    program.signal(SIGSTOP);
    constexpr timespec kStall{.tv_sec = 0, .tv_nsec = 300'000'000};
    ::nanosleep(&kStall, nullptr);
    program.signal(SIGCONT);
    ASSERT_TRUE(all(false));
    receiver.send(Bytes(behind.begin() + kHalf, behind.end()));
    const auto end = Clock::now() + 200ms;
    while (Clock::now() < end) {
        for (const SbusSight& sight : servos.listen()) {
            EXPECT_FALSE(sight.good()) << "channel 1 is " << sight.raw[0];
        }
        ::nanosleep(&kStep, nullptr);
    }
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::stall_test
