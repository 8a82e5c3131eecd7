#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <deque>
#include <random>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"
#include "tests/loopback/witness.h"

/// The program is stopped and goes on; its senders have gone on meanwhile.
namespace tribus::test {
namespace {

using namespace std::chrono_literals;

/// TRIBUS_LONG=1: some 360 stalls instead of 23.
int scale() {
    return std::getenv("TRIBUS_LONG") != nullptr ? 16 : 1;
}

/// A receiver, its line through the program, and the servos behind it.
class Line {
  public:
    Line(FarEnd& receiver, FarEnd& servos, unsigned number, Clock::duration most_age)
        : receiver_(receiver),
          servos_(servos),
          number_(number),
          ibus_(number % 2 == 0),
          witness_(number, most_age) {
        due_ = Clock::now() + number * 1ms;
    }
    std::string configuration(std::string_view input, std::string_view failsafe) const {
        return fmt::format(
            "[input.r{0}]\nprotocol = \"{1}\"\ndevice = \"{2}\"\n{3}\n"
            "[output.s{0}]\nprotocol = \"sbus\"\ndevice = \"{4}\"\nperiod = \"7ms\"\n"
            "[pipeline.p{0}]\nfrom = \"r{0}\"\nto = \"s{0}\"\n[pipeline.p{0}.failsafe]\n{5}\n",
            number_, ibus_ ? "ibus" : "sbus", receiver_.path(), input, servos_.path(), failsafe);
    }
    void turn() {
        const auto now = Clock::now();
        if (now >= due_) {
            due_ += ibus_ ? 7ms : 14ms;
            const Sticks sticks = witness_.next();
            const Bytes frame = ibus_ ? ibus_bytes(sticks) : sbus_bytes(sight(sticks));
            receiver_.send(frame) ? witness_.sent() : witness_.spoiled();
        }
        witness_.listen(servos_);
    }
    Witness& witness() { return witness_; }

  private:
    static SbusSight sight(const Sticks& sticks) {
        SbusSight sight = sbus_sight_of(sticks);
        sight.channel_17 = sight.channel_18 = false;
        return sight;
    }

    FarEnd& receiver_;
    FarEnd& servos_;
    unsigned number_;
    bool ibus_;
    Witness witness_;
    Clock::time_point due_;
};

class Stall : public Loopback {
  protected:
    Program& begin(int lines, std::string_view input, std::string_view failsafe,
                   Clock::duration most_age) {
        std::string text;
        for (int i = 0; i < lines; ++i) {
            FarEnd& receiver = device(fmt::format("r{}", i));
            lines_.emplace_back(receiver, device(fmt::format("s{}", i)), static_cast<unsigned>(i),
                                most_age);
            text += lines_.back().configuration(input, failsafe);
        }
        Program& program = run(write_config(text));
        EXPECT_TRUE(all_in_control());
        return program;
    }
    void go_on_for(Clock::duration time) {
        const auto end = Clock::now() + time;
        while (Clock::now() < end) {
            turn();
        }
    }
    bool all_in_control() {
        return eventually([this] {
            turn();
            return std::ranges::all_of(lines_,
                                       [](Line& line) { return line.witness().in_control(); });
        });
    }
    void turn() {
        for (Line& line : lines_) {
            line.turn();
        }
        constexpr timespec kPause{.tv_sec = 0, .tv_nsec = 500'000};
        ::nanosleep(&kPause, nullptr);
    }
    void expect_nothing_stale() {
        for (Line& line : lines_) {
            const Testimony& testimony = line.witness().testimony();
            EXPECT_EQ(testimony.too_old, 0U) << to_text(testimony);
            EXPECT_EQ(testimony.never_sent, 0U) << to_text(testimony);
            EXPECT_EQ(testimony.strays, 0U) << to_text(testimony);
        }
    }

    std::deque<Line> lines_;
    std::mt19937 random_{19};
};

/// A frame may be as old as its input's timeout, and speaks for one period.
TEST_F(Stall, longer_than_the_timeout_gives_no_unmarked_frame_that_is_older) {
    Program& program =
        begin(8, "timeout = \"100ms\"", "recover = \"0ms\"\npower_on = \"0ms\"", 100ms + 7ms);
    for (int stall = 0; stall < 12 * scale(); ++stall) {
        program.signal(SIGSTOP);
        go_on_for(200ms + std::chrono::milliseconds(random_() % 300));
        program.signal(SIGCONT);
        go_on_for(100ms + std::chrono::microseconds(random_() % 14'000));
        EXPECT_TRUE(all_in_control());
    }
    expect_nothing_stale();
    expect_clean_end(program);
}

/// More waits then than a terminal's line buffer holds: the kernel hands out the rest a moment
/// after the first part was read.
TEST_F(Stall, of_seconds_gives_no_unmarked_frame_that_is_older) {
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

TEST_F(Stall, longer_than_the_timeout_asks_for_recover_although_values_are_still_held) {
    Program& program = begin(2, "timeout = \"100ms\"", "hold = \"5s\"\nrecover = \"400ms\"", 1s);
    program.signal(SIGSTOP);
    go_on_for(300ms);
    const auto back = Clock::now();
    program.signal(SIGCONT);
    ASSERT_TRUE(eventually([this] {
        turn();
        return !lines_[0].witness().in_control();
    }));
    ASSERT_TRUE(eventually([this] {
        turn();
        return lines_[0].witness().in_control();
    }));
    EXPECT_GE(Clock::now() - back, 400ms);
    expect_clean_end(program);
}

TEST_F(Stall, shorter_than_the_timeout_is_followed_by_the_newest_frame) {
    Program& program = begin(8, "timeout = \"5s\"", "recover = \"0ms\"\npower_on = \"0ms\"", 10s);
    for (int stall = 0; stall < 8 * scale(); ++stall) {
        program.signal(SIGSTOP);
        go_on_for(300ms + std::chrono::microseconds(random_() % 14'000));
        std::uint64_t heard = 0;
        for (Line& line : lines_) {
            line.witness().want_the_newest();
            heard += line.witness().testimony().unmarked;
        }
        // So long may a busy machine take from a write to what a read finds.
        const timespec pause{.tv_sec = 0, .tv_nsec = 50'000'000};
        ::nanosleep(&pause, nullptr);
        program.signal(SIGCONT);
        const std::uint64_t enough = heard + 10 * lines_.size();
        ASSERT_TRUE(eventually([&] {
            turn();
            std::uint64_t now = 0;
            for (Line& line : lines_) {
                now += line.witness().testimony().unmarked;
            }
            return now >= enough;
        }));
    }
    for (Line& line : lines_) {
        const Testimony& testimony = line.witness().testimony();
        EXPECT_EQ(testimony.overtaken, 0U) << to_text(testimony);
    }
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test
