#include "transports/codecs/joystick/joystick.h"

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/channel_bytes.h"
#include "tests/support/streams.h"
#include "tests/unit/config/main_job.h"
#include "transports/links/uinput/uinput_medium.h"
#include "transports/registry/registry.h"

namespace tribus::test::joystick_test {
namespace {

using Lines = std::vector<std::string>;

std::string job(const std::string& lines, const std::string& name = "tribus") {
    return "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n"
           "[output.simulator]\nprotocol = \"joystick\"\nname = \"" +
           name + "\"\n" + lines + "[pipeline.main]\nfrom = \"receiver\"\nto = \"simulator\"\n";
}

/// The report of an output with these lines in the configuration.
Bytes report(const std::string& lines, const std::vector<double>& pulses) {
    const Configuration configuration = loaded(job(lines));
    const auto encoder = std::get<std::unique_ptr<ByteEncoder>>(
        kJoystickProtocol.make_encoder(configuration.outputs.at(0).settings));
    return encoded(*encoder, frame_of_microseconds(pulses));
}

std::vector<int> axes(const Bytes& report) {
    std::vector<int> values;
    for (std::size_t axis = 0; axis < 8; ++axis) {
        values.push_back(report.at(3 + 2 * axis) | report.at(4 + 2 * axis) << 8);
    }
    return values;
}
unsigned buttons(const Bytes& report) {
    return report.at(0) | static_cast<unsigned>(report.at(1)) << 8U |
           static_cast<unsigned>(report.at(2)) << 16U;
}

// EdgeTX: an axis is the mixer's output, -1024 (988 us) to 1023 (2011.5 us), plus 1024.
TEST(Joystick, HasAxesOfChannels1To8AndButtonsOfTheOthersAsARadioHas) {
    const Bytes bytes = report("", {988, 1000, 1500, 1500.5, 2000, 2011.5, 2500, 900,  //
                                    1501, 1500, 1499, 2000, 1000, 1000, 1000, 1000, 1000, 1501});
    EXPECT_EQ(bytes.size(), 19U);
    EXPECT_EQ(axes(bytes), (std::vector<int>{0, 24, 1024, 1025, 2024, 2047, 2047, 0}));
    EXPECT_EQ(buttons(bytes), 0b10'0000'1001U);
}

TEST(Joystick, WritesEveryPulseToTheNextStep) {
    for (int eighths = -32768; eighths <= 32767; ++eighths) {
        JoystickEncoder encoder({.axes = {0}, .buttons = {}, .throttle = {}});
        ChannelFrame frame;
        frame.set(0, Pulse::from_eighths(eighths));
        const double exact = (eighths / 8.0 - 988) * 2;
        ASSERT_NEAR(axes(encoded(encoder, frame))[0], std::min(std::max(exact, 0.0), 2047.0), 0.5)
            << eighths;
    }
}

TEST(Joystick, TakesAxesAndButtonsFromTheConfiguration) {
    const Bytes bytes = report(
        "axes = { ABS_X = 4, ABS_RUDDER = 1 }\nbuttons = { 1 = 5, 24 = 6, 9 = { channel = 7, below "
        "= 1300 "
        "}, 10 = { channel = 7, between = [1300, 1700] }, 11 = { channel = 7, above = 1700 } "
        "}\n",
        {1000, 1500, 1500, 2000, 2000, 1600, 1500});
    EXPECT_EQ(axes(bytes), (std::vector<int>{2024, 1024, 1024, 1024, 1024, 1024, 1024, 24}));
    EXPECT_EQ(buttons(bytes), 1U | 1U << 23U | 1U << 9U);
    for (const auto& [pulse, button] :
         {std::pair(1299, 8U), std::pair(1300, 9U), std::pair(1700, 9U), std::pair(1701, 10U)}) {
        const Bytes switched = report(
            "axes = {}\nbuttons = { 9 = { channel = 7, below = 1300 }, 10 = { channel = 7, between "
            "= [1300, 1700] }, 11 = { channel = 7, above = 1700 } }\n",
            {1500, 1500, 1500, 1500, 1500, 1500, static_cast<double>(pulse)});
        EXPECT_EQ(buttons(switched), 1U << button) << pulse;
    }
}

TEST(Joystick, NeedsTheChannelsThatItHasOnly) {
    JoystickEncoder encoder({.axes = {3, std::nullopt, 1},
                             .buttons = {{.button = 0, .channel = 17, .above = kCentrePulse}},
                             .throttle = {}});
    EXPECT_EQ(encoder.needed_channels({}), 1U << 3U | 1U << 1U | 1U << 17U);
}

TEST(Joystick, RestsInSilenceWithTheThrottleLowAndNoButtonPressed) {
    JoystickEncoder encoder({.axes = {0, 1, 2, 3},
                             .buttons = {{.button = 0, .channel = 0, .above = kCentrePulse}},
                             .throttle = 2});
    encoded(encoder, frame_of_microseconds({2000, 2000, 2000, 2000}));
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = encoder.write_silence(wire, {});
    const Bytes bytes(wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_EQ(axes(bytes), (std::vector<int>{1024, 1024, 0, 1024, 1024, 1024, 1024, 1024}));
    EXPECT_EQ(buttons(bytes), 0U);
}

TEST(Joystick, SaysWhatIsWrongInItsTables) {
    EXPECT_EQ(mistakes_in(job("axes = { ABS_W = 1 }\n")),
              Lines{"t.toml:7:18: unknown; allowed: ABS_X, ABS_Y, ABS_Z, ABS_RX, ABS_RY, ABS_RZ, "
                    "ABS_THROTTLE, ABS_RUDDER"});
    EXPECT_EQ(mistakes_in(job("axes = { ABS_X = 19 }\n")),
              Lines{"t.toml:7:18: allowed: a channel, 1 to 18"});
    EXPECT_EQ(mistakes_in(job("buttons = { 25 = 1 }\n")),
              Lines{"t.toml:7:18: unknown; allowed: buttons 1 to 24"});
    EXPECT_EQ(mistakes_in(job("buttons = { 1 = { channel = 1 } }\n")),
              Lines{"t.toml:7:17: allowed: a channel, or a table with channel and above, below or "
                    "between"});
    EXPECT_EQ(
        mistakes_in(job("buttons = { 1 = { channel = 1, above = 3000 } }\n")).front(),
        "t.toml:7:17: allowed: a channel, or a table with channel and above, below or between");
    EXPECT_EQ(mistakes_in(job("", std::string(79, 'x'))), Lines{});
    EXPECT_EQ(mistakes_in(job("", std::string(80, 'x'))),
              Lines{"t.toml:6:8: \"name\" is \"" + std::string(80, 'x') +
                    "\"; allowed: a name of 1 to 79 bytes"});
}

TEST(Joystick, GoesToAVirtualJoystickOnly) {
    EXPECT_EQ(media_for(kJoystickProtocol), std::vector<const Medium*>{&kUinputMedium});
    for (const Protocol* protocol : protocols()) {
        EXPECT_EQ(carries(kUinputMedium, *protocol), protocol == &kJoystickProtocol)
            << protocol->name;
    }
    EXPECT_EQ(mistakes_in(job("")), Lines{});
}

}  // namespace
}  // namespace tribus::test::joystick_test
