#pragma once

#include <algorithm>
#include <ctime>
#include <deque>
#include <random>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "tests/loopback/loopback.h"
#include "tests/loopback/witnessed_line.h"

namespace tribus::test {

/// The built program between several lines, each with a witness.
class Witnessed : public Loopback {
  protected:
    /// Starts the program and waits until all lines are in control.
    Program& begin(int lines, std::string_view input, std::string_view failsafe,
                   Clock::duration most_age) {
        std::string text;
        for (int i = 0; i < lines; ++i) {
            FarEnd& receiver = device(fmt::format("r{}", i));
            lines_.emplace_back(receiver, device(fmt::format("s{}", i)), static_cast<unsigned>(i),
                                most_age, stops_);
            text += lines_.back().configuration(input, failsafe);
        }
        Program& program = run(write_config(text));
        EXPECT_TRUE(all_in_control());
        return program;
    }
    void turn() {
        for (WitnessedLine& line : lines_) {
            line.turn();
        }
        constexpr timespec kPause{.tv_sec = 0, .tv_nsec = 500'000};
        ::nanosleep(&kPause, nullptr);
    }
    template <class Done>
    bool turn_until(Done done) {
        return eventually([&] {
            turn();
            return done();
        });
    }
    void go_on_for(Clock::duration time) {
        const auto end = Clock::now() + time;
        while (Clock::now() < end) {
            turn();
        }
    }
    bool all_in_control() {
        return turn_until([this] {
            return std::ranges::all_of(
                lines_, [](WitnessedLine& line) { return line.witness().in_control(); });
        });
    }
    std::chrono::microseconds up_to(std::chrono::microseconds most) {
        return std::chrono::microseconds(random_() % static_cast<std::uint64_t>(most.count()));
    }
    WitnessedLine& any_line() { return lines_[random_() % lines_.size()]; }

    MachineStops stops_;
    std::deque<WitnessedLine> lines_;
    std::mt19937 random_{19};
};

}  // namespace tribus::test
