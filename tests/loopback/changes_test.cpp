#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/loopback.h"
#include "tests/loopback/machine_stops.h"
#include "tests/loopback/recorded.h"

/// The changes of state that the built program tells.
namespace tribus::test::changes_test {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto kPeriod = 5ms;
constexpr auto kTimeout = 30ms;

std::int64_t in_us(Clock::time_point at) {
    return std::chrono::duration_cast<std::chrono::microseconds>(at.time_since_epoch()).count();
}

class Changes : public Loopback {
  protected:
    /// A receiver that says nothing from one time to another.
    struct Silence {
        Clock::time_point from;
        Clock::time_point to;
    };

    void send_for(Clock::duration time) {
        const auto end = Clock::now() + time;
        while (Clock::now() < end) {
            receiver_.send(frame_);
            servos_.receive();
            pause(kPeriod);
        }
        latest_ = Clock::now();
        receiver_.send(frame_);
    }
    Silence fall_silent_for(Clock::duration time) {
        const auto from = latest_;
        while (Clock::now() < from + time) {
            pause(1ms);
            servos_.receive();
        }
        const auto to = Clock::now();
        receiver_.send(frame_);
        return {from, to};
    }
    /// What `tribus status --watch` has told of the input.
    static std::vector<json> told(const Program& watching) {
        std::vector<json> changes;
        std::istringstream lines(watching.output());
        for (std::string line; std::getline(lines, line);) {
            json object = json::parse(line, nullptr, false);
            if (object.is_object() && object["type"] == "change" && object["part"] == "input") {
                changes.push_back(std::move(object));
            }
        }
        return changes;
    }
    static void pause(Clock::duration time) {
        const timespec pause{.tv_sec = 0, .tv_nsec = time.count()};
        ::nanosleep(&pause, nullptr);
    }

    FarEnd& receiver_ = device("receiver");
    FarEnd& servos_ = device("servos");

  private:
    Bytes frame_ = ibus_bytes(Sticks(14, 1500));
    Clock::time_point latest_;
};

/// With TRIBUS_LONG=1 there are 10,000 losses instead of 60.
TEST_F(Changes, TellEachShortLossOnceInItsOrderAndWithItsTime) {
    const int losses = std::getenv("TRIBUS_LONG") != nullptr ? 10'000 : 60;
    MachineStops stops;
    Program& program = run(write_config(main_job("timeout = \"30ms\"")));
    send_for(700ms);
    Program& watching = start(
        {"status", "--watch", "--format", "json", "--socket", (folder() / "control").string()});
    ASSERT_TRUE(eventually([&] {
        send_for(20ms);
        return !watching.output().empty();
    }));
    std::minstd_rand random(7);
    std::vector<Silence> silences;
    for (int loss = 0; loss < losses; ++loss) {
        send_for(60ms);
        // From the timeout on the link is lost.
        silences.push_back(
            fall_silent_for(kTimeout + 20ms + std::chrono::microseconds(random() % 40'000)));
    }
    send_for(700ms);
    const std::vector<json> changes = told(watching);
    EXPECT_TRUE(std::ranges::is_sorted(
        changes, [](const json& a, const json& b) { return a["number"] < b["number"]; }));
    std::size_t next = 0;
    for (const Silence& silence : silences) {
        // A machine that stops makes losses of its own, and may hide the end of one.
        if (stops.within(silence.from - 100ms, silence.to + 100ms) > 0ms) {
            continue;
        }
        const auto is_its_loss = [&](const json& change) {
            return change["now"] == "wire_silent" &&
                   change["t_us"] >= in_us(silence.from + kTimeout) &&
                   change["t_us"] <= in_us(silence.to);
        };
        const auto first = changes.begin() + static_cast<std::ptrdiff_t>(next);
        const auto lost = std::find_if(first, changes.end(), is_its_loss);
        ASSERT_NE(lost, changes.end()) << "a silence of " << (silence.to - silence.from) / 1us
                                       << " us at " << in_us(silence.from) << '\n'
                                       << watching.output();
        EXPECT_EQ(std::count_if(changes.begin(), changes.end(), is_its_loss), 1);
        next = static_cast<std::size_t>(lost - changes.begin()) + 1;
        ASSERT_LT(next, changes.size());
        EXPECT_NE(changes[next]["now"], "wire_silent");
        EXPECT_GE(changes[next]["t_us"], in_us(silence.to - 1ms));
    }
    EXPECT_EQ(count_of("changes_lost", watching.output()), 0U);
    watching.signal(SIGTERM);
    watching.end();
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::changes_test
