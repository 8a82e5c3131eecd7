#include "transports/codecs/gamepad/gamepad.h"

#include <linux/input-event-codes.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/channel_bytes.h"
#include "tests/support/streams.h"
#include "tests/unit/config/main_job.h"
#include "transports/codecs/gamepad/codes.h"
#include "transports/links/evdev/evdev_medium.h"
#include "transports/registry/registry.h"

namespace tribus::test::gamepad_test {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

// Codes of linux/input-event-codes.h.
constexpr int kAbsX = 0x00;
constexpr int kAbsY = 0x01;
constexpr int kAbsZ = 0x02;
constexpr int kAbsRx = 0x03;
constexpr int kAbsRy = 0x04;
constexpr int kBtnSouth = 0x130;
constexpr int kBtnEast = 0x131;
constexpr int kBtnTl = 0x136;

struct State {
    std::map<int, int> axes{{kAbsX, 0}, {kAbsY, 0}, {kAbsRx, 0}, {kAbsRy, 0}};
    std::vector<int> pressed{};
    bool changed = true;
    bool gone = false;
};

/// A report by the layout of docs/protocols/gamepad.md.
Bytes report(const State& state) {
    Bytes bytes{0x67, static_cast<std::uint8_t>((state.gone ? 1 : 0) | (state.changed ? 2 : 0)),
                static_cast<std::uint8_t>(state.axes.size()),
                static_cast<std::uint8_t>(state.pressed.size())};
    for (const auto& [code, position] : state.axes) {
        append(bytes, Bytes{static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(position),
                            static_cast<std::uint8_t>(position >> 8)});
    }
    for (const int code : state.pressed) {
        append(bytes, Bytes{static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(code >> 8)});
    }
    return bytes;
}

std::string job(const std::string& lines) {
    return "[input.pad]\nprotocol = \"gamepad\"\ndevice = \"/dev/input/by-id/pad\"\n" + lines +
           "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n"
           "[pipeline.main]\nfrom = \"pad\"\nto = \"servos\"\n";
}

/// A decoder with these lines in the configuration.
class Pad {
  public:
    explicit Pad(const std::string& lines = "") {
        const Configuration configuration = loaded(job(lines));
        decoder_ = make_byte_decoder(kGamepadProtocol, configuration.inputs.at(0).settings);
    }
    ChannelFrame hear(const State& state, Duration at = 0ms) {
        const auto frames = feed(*decoder_, report(state), kOneRead, Instant{} + at);
        EXPECT_EQ(frames.size(), 1U);
        return frames.empty() ? ChannelFrame{} : frames[0].channels;
    }
    ByteDecoder& decoder() { return *decoder_; }

  private:
    std::unique_ptr<ByteDecoder> decoder_;
};

TEST(Gamepad, HasTheSticksAsAilerElevatorThrottleRudderByDefault) {
    Pad pad;
    const ChannelFrame frame =
        pad.hear({.axes = {{kAbsX, 32767}, {kAbsY, -32767}, {kAbsRx, -32767}, {kAbsRy, 16384}},
                  .pressed = {kBtnEast}});
    EXPECT_EQ(pulses_of(frame),
              (std::vector<double>{1000, 1750, 2000, 2000, 1000, 2000, 1000, 1000}));
    EXPECT_TRUE(frame.good());
}

TEST(Gamepad, ReadsEveryPositionToTheNextEighth) {
    Pad pad("axes = { ABS_Z = 1, ABS_X = { channel = 2, reverse = true } }\nbuttons = {}\n");
    for (int position = -32767; position <= 32767; ++position) {
        const ChannelFrame frame = pad.hear({.axes = {{kAbsZ, position}, {kAbsX, position}}});
        const double exact = 500.0 * position / 32767;
        ASSERT_NEAR(frame.channel(0)->microseconds(), 1500 + exact, 0.0626) << position;
        ASSERT_NEAR(frame.channel(1)->microseconds(), 1500 - exact, 0.0626) << position;
    }
}

TEST(Gamepad, LeavesAChannelOutWhoseAxisTheDeviceLacks) {
    Pad pad;
    const ChannelFrame frame = pad.hear({.axes = {{kAbsX, 0}, {kAbsY, 0}}});
    EXPECT_FALSE(frame.has(0));
    EXPECT_TRUE(frame.has(2));
}

TEST(Gamepad, ATogglingButtonChangesWithEachPress) {
    Pad pad("buttons = { BTN_SOUTH = { channel = 5, toggle = true } }\n");
    const State pressed{.pressed = {kBtnSouth}};
    std::vector<double> seen;
    for (const State& state : {State{}, pressed, pressed, State{}, State{}, pressed, State{}}) {
        seen.push_back(pad.hear(state).channel(4)->microseconds());
    }
    EXPECT_EQ(seen, (std::vector<double>{1000, 2000, 2000, 2000, 2000, 1000, 1000}));
}

TEST(Gamepad, IsFailsafeWhenTheDeviceIsGone) {
    Pad pad;
    EXPECT_FALSE(pad.hear({}).failsafe);
    EXPECT_TRUE(pad.hear({.gone = true}).failsafe);
}

TEST(Gamepad, NeedsRestAndThenAPressAfterAReturn) {
    Pad pad;
    const State held{.axes = {{kAbsX, 0}, {kAbsY, 20000}, {kAbsRx, 0}, {kAbsRy, 0}}};
    const State pressed{.pressed = {kBtnSouth}};
    EXPECT_FALSE(pad.hear(held).failsafe) << "at the start it counts at once";
    pad.decoder().reset();
    EXPECT_TRUE(pad.hear(held).failsafe) << "a stick is held";
    State held_and_pressed = held;
    held_and_pressed.pressed = {kBtnSouth};
    EXPECT_TRUE(pad.hear(held_and_pressed).failsafe) << "a press before rest does not count";
    EXPECT_TRUE(pad.hear(pressed).failsafe) << "a button that stays pressed is no press";
    EXPECT_TRUE(pad.hear({}).failsafe);
    EXPECT_FALSE(pad.hear(pressed).failsafe);
    EXPECT_FALSE(pad.hear(held).failsafe);
}

TEST(Gamepad, ATriggerRestsAtItsEndAndASwitchIsOffAfterAReturn) {
    Pad pad("axes = { ABS_Z = 1 }\nbuttons = { BTN_SOUTH = { channel = 5, toggle = true } }\n");
    const auto with_trigger = [](int position) { return State{.axes = {{kAbsZ, position}}}; };
    pad.hear({.axes = {{kAbsZ, -32767}}, .pressed = {kBtnSouth}});
    EXPECT_EQ(pad.hear(with_trigger(-32767)).channel(4)->microseconds(), 2000);
    pad.decoder().reset();
    pad.hear(with_trigger(-32767));
    const ChannelFrame frame = pad.hear({.axes = {{kAbsZ, -32767}}, .pressed = {kBtnEast}});
    EXPECT_FALSE(frame.failsafe);
    EXPECT_EQ(frame.channel(4)->microseconds(), 1000);
    pad.decoder().reset();
    for (const int position : {3277, -29000, 32767}) {
        pad.hear(with_trigger(position));
        EXPECT_TRUE(pad.hear({.axes = {{kAbsZ, position}}, .pressed = {kBtnEast}}).failsafe)
            << position;
        pad.hear(with_trigger(position));
    }
}

TEST(Gamepad, CountsOnlyWhileTheDeadMansButtonIsPressed) {
    Pad pad("dead_man = \"BTN_TL\"\n");
    EXPECT_TRUE(pad.hear({}).failsafe);
    EXPECT_FALSE(pad.hear({.pressed = {kBtnTl}}).failsafe);
    EXPECT_TRUE(pad.hear({.pressed = {kBtnSouth}}).failsafe);
}

TEST(Gamepad, IsLostWhenNothingMovedForTheActivityTimeout) {
    Pad pad("activity_timeout = \"2s\"\n");
    EXPECT_FALSE(pad.hear({.changed = true}, 0ms).failsafe);
    EXPECT_FALSE(pad.hear({.changed = false}, 1999ms).failsafe);
    EXPECT_TRUE(pad.hear({.changed = false}, 2000ms).failsafe);
    EXPECT_FALSE(pad.hear({.changed = true}, 2020ms).failsafe);
    Pad still;
    still.hear({.changed = true}, 0ms);
    EXPECT_FALSE(still.hear({.changed = false}, 10h).failsafe) << "silence is normal without it";
}

TEST(Gamepad, SaysWhatIsWrongInItsTables) {
    EXPECT_EQ(mistakes_in(job("axes = { ABS_Q = 1 }\n")),
              Lines{"t.toml:4:18: no axis; allowed: a name such as ABS_X, as `evtest` shows it"});
    EXPECT_EQ(mistakes_in(job("axes = { ABS_X = 0 }\n")),
              Lines{"t.toml:4:18: allowed: a channel, 1 to 18, or a table with channel and "
                    "reverse"});
    EXPECT_EQ(mistakes_in(job("buttons = { BTN_SOUTH = { channel = 5, reverse = true } }\n")),
              Lines{"t.toml:4:50: allowed: channel, and toggle = true or false"});
    EXPECT_EQ(mistakes_in(job("dead_man = \"TL\"\n")),
              Lines{"t.toml:4:12: \"dead_man\" is \"TL\", no button of a gamepad; allowed: a name "
                    "such as \"BTN_TL\", as `evtest` shows it"});
    EXPECT_EQ(mistakes_in(job("axes = {}\nbuttons = {}\n")).size(), 1U);
}

TEST(Gamepad, ReadsNoReportThatIsNotWhole) {
    GamepadDecoder decoder({.axes = {{.code = 0, .channel = 0}}, .buttons = {}});
    const Bytes whole = report({.pressed = {kBtnSouth}});
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_EQ(
            feed(decoder, Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)))
                .size(),
            0U);
        DecodedFrame frame;
        while (decoder.silence(frame)) {
            ADD_FAILURE() << length;
        }
    }
    Bytes wrong = whole;
    wrong[1] = 0x10;
    EXPECT_EQ(feed(decoder, wrong).size(), 0U);
}

TEST(Gamepad, ComesFromAnInputDeviceOnly) {
    EXPECT_EQ(media_for(kGamepadProtocol), std::vector<const Medium*>{&kEvdevMedium});
    EXPECT_EQ(loaded(job("grab = false\n")).inputs[0].port.medium, &kEvdevMedium);
    EXPECT_FALSE(kGamepadProtocol.goes(SettingScope::output));
}

TEST(GamepadCodes, HaveTheNamesOfTheKernel) {
    EXPECT_EQ(gamepad_button_code("BTN_DEAD"), BTN_DEAD);
    EXPECT_EQ(gamepad_button_code("BTN_TRIGGER_HAPPY1"), BTN_TRIGGER_HAPPY1);
    EXPECT_EQ(gamepad_button_code("BTN_TRIGGER_HAPPY40"), BTN_TRIGGER_HAPPY40);
    EXPECT_EQ(gamepad_axis_code("ABS_HAT1Y"), ABS_HAT1Y);
    for (const char* no_button : {"BTN_TRIGGER_HAPPY", "BTN_TRIGGER_HAPPY0", "BTN_TRIGGER_HAPPY41",
                                  "BTN_TRIGGER_HAPPY01", "BTN_LEFT", ""}) {
        EXPECT_FALSE(gamepad_button_code(no_button)) << no_button;
    }
}

TEST(GamepadCodes, AreThoseOfTheirNames) {
    int named = 0;
    for (std::uint16_t code = 0; code < KEY_CNT; ++code) {
        const std::string name = gamepad_button_name(code);
        if (!name.empty()) {
            EXPECT_EQ(gamepad_button_code(name), code);
            ++named;
        }
    }
    EXPECT_EQ(named, 72);
}

}  // namespace
}  // namespace tribus::test::gamepad_test
