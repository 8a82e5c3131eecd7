#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/client/ask_daemon.h"
#include "tests/loopback/loopback.h"
#include "tests/reference/plain_crsf.h"

/// The built program as the handset of a transmitter module on a pty, which talks as modules of
/// ExpressLRS 4 do: its frames begin with C8 (docs/protocols/crsf.md, "Towards a transmitter
/// module").
namespace tribus::test::handset_test {
namespace {

using reference::plain_crsf;
using reference::PlainCrsfFrame;
using std::chrono::microseconds;
using std::chrono::milliseconds;

/// The module wants frames with this period; their phase is right.
Bytes timing(microseconds period) {
    return reference::plain_crsf_timing(static_cast<std::uint32_t>(10 * period.count()), 0, 0xC8);
}

class HandsetOfAModule : public Loopback {
  protected:
    Program& run_handset() {
        return run(write_config(R"(
[input.radio]
protocol = "crsf"
device = "@radio"

[output.module]
protocol = "crsf"
role = "handset"
baud = 400000
model_id = 7
device = "@module"

[pipeline.main]
from = "radio"
to = "module"
)"));
    }
    /// A receiver at 150 Hz, and the module each 200 ms, until the condition holds.
    template <class Condition>
    bool flies_until(const Bytes& word, Condition condition) {
        return eventually([&] {
            const auto now = Clock::now();
            if (now - radio_at_ >= microseconds(6667)) {
                radio_at_ = now;
                std::array<std::uint16_t, 16> centred{};
                centred.fill(992);
                radio_.send(plain_crsf(0xC8, 0x16, reference::plain_crsf_packed(centred)));
            }
            if (!word.empty() && now - word_at_ >= milliseconds(200)) {
                word_at_ = now;
                module_.send(word);
            }
            const Bytes more = module_.receive();
            heard_.insert(heard_.end(), more.begin(), more.end());
            return condition();
        });
    }
    Clock::duration time_of_100_frames(const Bytes& word) {
        module_.receive();
        heard_.clear();
        const auto begin = Clock::now();
        EXPECT_TRUE(flies_until(word, [&] { return of_type(0x16).size() >= 100; }));
        return Clock::now() - begin;
    }
    /// What the status says of the output.
    nlohmann::json told() const {
        const auto status = ask_daemon((folder() / "control").string(), "status", kPatience);
        return status ? status->at("outputs").at(0) : nlohmann::json::object();
    }
    std::vector<PlainCrsfFrame> of_type(std::uint8_t type) const {
        std::vector<PlainCrsfFrame> frames;
        for (PlainCrsfFrame& frame : reference::plain_crsf_frames(heard_)) {
            if (frame.type == type) {
                frames.push_back(std::move(frame));
            }
        }
        return frames;
    }

    FarEnd& radio_ = device("radio");
    FarEnd& module_ = device("module");
    Bytes heard_;
    Clock::time_point radio_at_{};
    Clock::time_point word_at_{};
};

/// A hundred frames at 20 ms take 1.98 s, and on a busy machine longer. At 2 ms they take 0.2 s,
/// and on a busy machine longer most of the time; at the 4 ms that nobody asked for never less than
/// 0.39 s.
TEST_F(HandsetOfAModule, FollowsATimingOf2And20Milliseconds) {
    Program& program = run_handset();
    const auto is_told = [&](microseconds period) {
        EXPECT_TRUE(flies_until(timing(period), [&] {
            return told()["period_us"] == period.count();
        })) << program.errors();
        EXPECT_EQ(told()["module"], "heard");
    };
    is_told(milliseconds(2));
    const auto end = Clock::now() + kPatience;
    Clock::duration quickest = kPatience;
    while (quickest >= milliseconds(390) && Clock::now() < end) {
        quickest = std::min(quickest, time_of_100_frames(timing(milliseconds(2))));
    }
    EXPECT_LT(quickest, milliseconds(390));
    is_told(milliseconds(20));
    EXPECT_GE(time_of_100_frames(timing(milliseconds(20))), milliseconds(1900));
    is_told(milliseconds(20));
    EXPECT_TRUE(program.says("output module: under control of radio; hears its module"));
    expect_clean_end(program);
}

TEST_F(HandsetOfAModule, TellsTheModelOnce) {
    Program& program = run_handset();
    const Bytes word = timing(milliseconds(4));
    EXPECT_TRUE(flies_until(word, [&] { return !of_type(0x32).empty(); })) << program.errors();
    EXPECT_TRUE(flies_until(word, [&] { return of_type(0x16).size() >= 500; }));
    const std::vector<PlainCrsfFrame> commands = of_type(0x32);
    ASSERT_EQ(commands.size(), 1U);
    EXPECT_EQ(commands[0].payload.at(4), 7U);
    expect_clean_end(program);
}

TEST_F(HandsetOfAModule, SaysThatItIsSilentAndThenUnreadable) {
    Program& program = run_handset();
    EXPECT_TRUE(flies_until({}, [&] { return told()["module"] == "silent"; }));
    EXPECT_TRUE(program.says("output module: under control of radio; hears nothing of its module"));
    const Bytes rubbish{0x55, 0xAA, 0xC8, 0x0D, 0x3A};
    EXPECT_TRUE(flies_until(rubbish, [&] { return told()["module"] == "unreadable"; }));
    EXPECT_TRUE(program.says("what comes back is no frame of a module"));
    const Bytes word = timing(milliseconds(4));
    EXPECT_TRUE(flies_until(word, [&] { return told()["module"] == "heard"; }));
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::handset_test
