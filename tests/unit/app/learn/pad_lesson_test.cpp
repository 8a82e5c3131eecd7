#include "app/learn/pad_lesson.h"

#include <linux/input-event-codes.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/gamepad_report.h"
#include "tests/support/streams.h"
#include "tests/unit/config/main_job.h"
#include "transports/links/evdev/evdev_state.h"
#include "transports/registry/registry.h"

/// What a person shows with a gamepad becomes lines of a configuration.
namespace tribus::test::pad_lesson_test {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

constexpr int kEnd = gamepad_report::kFullDeflection;
constexpr std::uint16_t kNameless = BTN_BASE6 + 1;  // the kernel has no name for it

input_absinfo range(int value, int least, int most) {
    return {value, least, most, 0, 0, 0};
}

/// A person with a pad of two sticks, a trigger and a lever. Sticks come back when they are let go.
class PadPerson {
  public:
    /// `guided`: a program says when a step is done, and the lesson does not go on by itself.
    explicit PadPerson(bool guided = false) : guided_(guided) {}

    void wait(Duration time) {
        for (const Instant end = now_ + time; now_ < end; now_ += 20ms) {
            lesson_.see(pad_, now_);
            remarks_ += lesson_.take_remark();
            if (!guided_ && lesson_.is_complete(now_)) {
                go_on();
            }
        }
    }
    void go_on() {
        lesson_.next(now_);
        remarks_ += lesson_.take_remark();
    }
    void rest() { wait(1500ms); }
    void put(std::uint16_t code, int position) {
        for (PadSight::Axis& axis : pad_.axes) {
            axis.position = axis.code == code ? position : axis.position;
        }
    }
    /// Moves a stick there in some steps, and lets go.
    void move(std::uint16_t code, int position) {
        for (const int way : {position / 2, position}) {
            put(code, way);
            wait(100ms);
        }
        put(code, 0);
        wait(300ms);
    }
    void press(std::uint16_t code, Duration time) {
        pad_.pressed.push_back(code);
        wait(time);
        pad_.pressed.clear();
        wait(300ms);
    }
    /// Nothing for all four channels of sticks.
    void leave_sticks_out() {
        for (int channel = 1; channel <= 4; ++channel) {
            go_on();
        }
    }
    Lines lines() const { return pad_lines(lesson_.learned()); }
    const PadLesson& lesson() const { return lesson_; }
    PadSight& pad() { return pad_; }
    std::string take_remarks() { return std::exchange(remarks_, {}); }

  private:
    bool guided_;
    Instant now_ = Instant(1h);
    PadSight pad_{.axes = {{ABS_X, 0},
                           {ABS_Y, 0},
                           {ABS_Z, -kEnd},
                           {ABS_RX, 0},
                           {ABS_RY, 0},
                           {ABS_THROTTLE, -kEnd}},
                  .pressed = {}};
    PadLesson lesson_;
    std::string remarks_;
};

TEST(PadLesson, MakesLinesOfTheSticksAndButtonsThatWereShown) {
    PadPerson person;
    EXPECT_EQ(person.lesson().prompt(), "Let go of all sticks, triggers and buttons.");
    person.rest();
    EXPECT_EQ(person.lesson().prompt().rfind("Channel 1, aileron or steering (right): move", 0),
              0U);
    person.move(ABS_RX, kEnd);
    person.move(ABS_RY, kEnd);
    person.move(ABS_Y, -kEnd);
    person.move(ABS_X, kEnd);
    person.press(BTN_SOUTH, 2s);
    person.press(BTN_START, 200ms);
    person.go_on();
    EXPECT_EQ(person.lesson().step(), PadStep::dead_man);
    person.press(BTN_TL, 1500ms);
    EXPECT_EQ(person.lesson().step(), PadStep::done);
    EXPECT_EQ(
        person.lines(),
        (Lines{"axes     = { ABS_RX = 1, ABS_RY = 2, ABS_Y = { channel = 3, reverse = true }, "
               "ABS_X = 4 }",
               "buttons  = { BTN_SOUTH = 5, BTN_START = { channel = 6, toggle = true } }",
               "dead_man = \"BTN_TL\""}));
    EXPECT_EQ(person.take_remarks(),
              "Channel 1 is ABS_RX.Channel 2 is ABS_RY.Channel 3 is ABS_Y, reversed."
              "Channel 4 is ABS_X.Channel 5 is BTN_SOUTH, while it is pressed."
              "Channel 6 is BTN_START, changed by each press.The dead man's button is BTN_TL.");
}

TEST(PadLesson, LinesAreAcceptedAsAConfigurationAndMeanWhatWasShown) {
    PadPerson person;
    person.rest();
    person.go_on();
    person.move(ABS_X, -kEnd);
    person.go_on();
    person.go_on();
    person.go_on();
    person.go_on();
    ASSERT_EQ(person.lines(),
              (Lines{"axes     = { ABS_X = { channel = 2, reverse = true } }", "buttons  = {}"}));
    std::string text = "[input.pad]\nprotocol = \"gamepad\"\ndevice = \"/dev/input/by-id/pad\"\n";
    for (const std::string& line : person.lines()) {
        text += line + "\n";
    }
    const Configuration configuration =
        loaded(text +
               "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n"
               "[pipeline.main]\nfrom = \"pad\"\nto = \"servos\"\n");
    const auto decoder = make_byte_decoder(kGamepadProtocol, configuration.inputs.at(0).settings);
    EvdevState state;
    state.add_axis(ABS_X, range(-100, -100, 100));
    std::array<std::uint8_t, gamepad_report::kMostBytes> report{};
    const std::size_t size = state.write(report, false);
    const auto frames =
        feed(*decoder, Bytes(report.begin(), report.begin() + static_cast<std::ptrdiff_t>(size)),
             kOneRead, Instant{});
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_TRUE(frames[0].channels.has(1));
    EXPECT_EQ(frames[0].channels.channel_or(1, Pulse{}).whole_microseconds(), 2000);
    EXPECT_FALSE(frames[0].channels.has(0));
}

TEST(PadLesson, BeginsOnlyWhenNobodyTouchesThePad) {
    PadPerson person;
    person.pad().pressed = {BTN_SOUTH};
    person.wait(3s);
    EXPECT_EQ(person.lesson().step(), PadStep::rest) << "a button is pressed";
    person.pad().pressed.clear();
    for (int i = 0; i < 10; ++i) {
        person.put(ABS_X, i % 2 == 0 ? kEnd / 4 : 0);
        person.wait(500ms);
    }
    EXPECT_EQ(person.lesson().step(), PadStep::rest) << "a stick moves";
    person.put(ABS_X, 0);
    person.rest();
    EXPECT_EQ(person.lesson().step(), PadStep::channel);
}

TEST(PadLesson, TakesATriggerThatRestsAtItsEndAndALeverThatStaysWhereItIs) {
    PadPerson person;
    person.rest();
    person.put(ABS_Z, kEnd);
    person.wait(300ms);
    EXPECT_TRUE(person.lines()[0].ends_with("{}")) << "it is not let go yet";
    person.put(ABS_Z, -kEnd);
    person.wait(300ms);
    person.put(ABS_THROTTLE, kEnd);
    person.wait(1s);
    EXPECT_EQ(person.lines()[0], "axes     = { ABS_Z = 1 }");
    person.wait(2s);
    EXPECT_EQ(person.lines()[0], "axes     = { ABS_Z = 1, ABS_THROTTLE = 2 }");
    person.move(ABS_X, kEnd);
    EXPECT_EQ(person.lines()[0], "axes     = { ABS_Z = 1, ABS_THROTTLE = 2, ABS_X = 3 }");
}

TEST(PadLesson, DoesNotTakeAStickThatOnlyTrembledOrWentHalfWay) {
    PadPerson person;
    person.rest();
    person.move(ABS_X, kEnd / 2);
    person.wait(1s);
    EXPECT_EQ(person.lines()[0], "axes     = {}");
    EXPECT_EQ(person.take_remarks(), "");
}

TEST(PadLesson, AsksAgainWhenTwoAxesWentAlike) {
    for (const bool guided : {false, true}) {
        PadPerson person(guided);
        person.rest();
        if (guided) {
            person.go_on();
        }
        person.put(ABS_X, kEnd);
        person.put(ABS_Y, kEnd * 8 / 10);
        person.wait(300ms);
        person.put(ABS_X, 0);
        person.put(ABS_Y, 0);
        person.wait(300ms);
        EXPECT_EQ(person.take_remarks(), "ABS_X and ABS_Y moved alike; move one.");
        if (guided) {
            person.go_on();
        }
        EXPECT_EQ(person.lesson().prompt().rfind("Channel 1,", 0), 0U) << "the same step";
        person.put(ABS_Y, kEnd / 4);
        person.move(ABS_X, kEnd);
        if (guided) {
            person.go_on();
        }
        EXPECT_EQ(person.lines()[0], "axes     = { ABS_X = 1 }");
    }
}

TEST(PadLesson, TakesNoControlTwice) {
    PadPerson person;
    person.rest();
    person.move(ABS_X, kEnd);
    person.take_remarks();
    person.move(ABS_X, -kEnd);
    EXPECT_EQ(person.take_remarks(), "ABS_X is channel 1 already; take another.");
    person.go_on();
    person.go_on();
    person.go_on();
    person.go_on();
    EXPECT_EQ(person.lesson().prompt().rfind("Channel 5:", 0), 0U);
    person.press(BTN_EAST, 200ms);
    person.take_remarks();
    person.press(BTN_EAST, 200ms);
    EXPECT_EQ(person.take_remarks(), "BTN_EAST is channel 5 already; take another.");
    person.go_on();
    person.go_on();
    EXPECT_EQ(person.lesson().step(), PadStep::dead_man);
    person.press(BTN_EAST, 2s);
    EXPECT_EQ(person.take_remarks(), "BTN_EAST is channel 5 already; take another.");
    EXPECT_EQ(person.lesson().step(), PadStep::dead_man);
}

TEST(PadLesson, TakesNothingThatAConfigurationCannotName) {
    PadPerson person;
    person.pad().axes.push_back({ABS_MISC, 0});
    person.rest();
    person.move(ABS_MISC, kEnd);
    EXPECT_EQ(person.take_remarks(),
              "A configuration has no name for the axis with the code 28; take another.");
    person.go_on();
    person.leave_sticks_out();
    person.press(kNameless, 200ms);
    EXPECT_EQ(person.take_remarks(),
              "A configuration has no name for the button with the code 12C; take another.");
    EXPECT_EQ(person.lines(), (Lines{"axes     = {}", "buttons  = {}"}));
}

TEST(PadLesson, WantsTheDeadMansButtonHeldForASecond) {
    PadPerson person;
    person.rest();
    person.leave_sticks_out();
    person.go_on();
    ASSERT_EQ(person.lesson().step(), PadStep::dead_man);
    person.press(BTN_TL, 500ms);
    EXPECT_EQ(person.take_remarks(), "BTN_TL was released too early; hold it for a second.");
    EXPECT_EQ(person.lesson().step(), PadStep::dead_man);
    person.press(BTN_TR, 1100ms);
    EXPECT_EQ(person.lines().back(), "dead_man = \"BTN_TR\"");
}

TEST(PadLesson, GoesOnWhenTheProgramThatGuidesThePersonSaysSo) {
    PadPerson person(true);
    person.wait(200ms);
    person.go_on();
    EXPECT_EQ(person.take_remarks(), "The sticks still move. Let go and wait for a second.");
    person.rest();
    person.go_on();
    person.move(ABS_RX, kEnd);
    EXPECT_EQ(person.lines()[0], "axes     = {}");
    person.go_on();
    EXPECT_EQ(person.lines()[0], "axes     = { ABS_RX = 1 }");
}

TEST(PadLesson, EndsWithTheLastChannel) {
    PadPerson person;
    person.rest();
    person.leave_sticks_out();
    for (std::uint16_t i = 0; i < 14; ++i) {
        EXPECT_EQ(person.lesson().step(), PadStep::channel);
        person.press(static_cast<std::uint16_t>(BTN_SOUTH + i), 200ms);
    }
    EXPECT_EQ(person.lesson().step(), PadStep::dead_man);
}

TEST(PadReport, IsReadAsTheLinkWritesIt) {
    EvdevState state;
    state.add_axis(ABS_X, range(0, -100, 100));
    state.add_axis(ABS_GAS, range(0, 0, 255));
    state.set_button(BTN_TL, true);
    state.set_button(BTN_START, true);
    std::array<std::uint8_t, gamepad_report::kMostBytes> report{};
    const std::size_t size = state.write(report, true);
    const auto sight = pad_sight_of(std::span(report).first(size));
    ASSERT_TRUE(sight);
    ASSERT_EQ(sight->axes.size(), 2U);
    EXPECT_EQ(sight->axes[0].code, ABS_X);
    EXPECT_EQ(sight->axes[0].position, 0);
    EXPECT_EQ(sight->axes[1].code, ABS_GAS);
    EXPECT_EQ(sight->axes[1].position, -kEnd);
    EXPECT_EQ(sight->pressed, (std::vector<std::uint16_t>{BTN_TL, BTN_START}));
    EXPECT_TRUE(sight->gone);
    EXPECT_FALSE(pad_sight_of(std::span(report).first(size - 1)));
    EXPECT_FALSE(pad_sight_of({}));
}

TEST(DeadMansButton, IsSuggestedWhereAFingerRestsAndNoChannelIs) {
    const std::vector<std::uint16_t> pad{BTN_SOUTH, BTN_TL, BTN_TR};
    GamepadSettings learned;
    EXPECT_EQ(dead_man_for(learned, pad), "BTN_TL");
    learned.buttons = {{.code = BTN_TL, .channel = 4}};
    EXPECT_EQ(dead_man_for(learned, pad), "BTN_TR");
    EXPECT_EQ(dead_man_for(learned, std::vector<std::uint16_t>{BTN_SOUTH}), "");
}

}  // namespace
}  // namespace tribus::test::pad_lesson_test
