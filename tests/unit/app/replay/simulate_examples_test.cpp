#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/shell.h"
#include "tests/unit/transports/codecs/mavlink/mavlink_messages.h"

/// Examples that lead from one protocol to another, as they are shipped, over made recordings: the
/// values come through the map, and a loss looks as the comments of the files say.
namespace tribus::test::simulate_examples_test {
namespace {

using Pulses = std::vector<std::optional<double>>;

/// Multiples of 5 us, which each of the protocols has exactly.
const std::vector<int> kSticks{1700, 1600, 1300, 1450, 2000, 1000, 1100, 1200,
                               1350, 1400, 1500, 1550, 1650, 1750, 1800, 1900};
constexpr std::int64_t kStickPeriod = 7700;      ///< us
constexpr std::int64_t kLastStick = 129 * 7700;  ///< us

/// Channels of `sticks` from 1 to `count`, the others absent.
Pulses pulses(const std::vector<int>& sticks, std::size_t count = 18) {
    Pulses channels(18);
    for (std::size_t channel = 0; channel < std::min(count, sticks.size()); ++channel) {
        channels[channel] = sticks[channel];
    }
    return channels;
}

/// A frame that an output sent.
struct Sent {
    std::int64_t at = 0;  ///< us
    Pulses channels;
    bool frame_lost = false;
    bool failsafe = false;

    bool good() const { return !frame_lost && !failsafe; }
};

class SimulatedExample : public testing::Test {
  protected:
    /// Recorded bytes of a receiver that sends `kSticks` for a second.
    void make_receiver(const std::string& protocol) const {
        std::string lines;
        for (std::int64_t at = 0; at <= kLastStick; at += kStickPeriod) {
            lines +=
                fmt::format("{{\"t_us\":{},\"channels\":[{}]}}\n", at, fmt::join(kSticks, ","));
        }
        folder_.write("sticks.jsonl", lines);
        run("\"$TRIBUS\" encode --protocol " + protocol +
            " --format timed sticks.jsonl > receiver.txt");
    }
    /// Runs an example of config/examples. `ways` are the options --in and --out.
    void simulate(const std::string& example, const std::string& ways) const {
        run("\"$TRIBUS\" simulate " TRIBUS_SOURCE_DIR "/config/examples/" + example + ".toml " +
            ways + " --tail 1s");
    }
    std::string run(const std::string& command) const {
        const Ended ended = run_in_shell("cd '" + folder_ / "" + "'; " + command);
        EXPECT_EQ(ended.status, 0) << command << "\n" << ended.output;
        return ended.output;
    }
    std::vector<Sent> decoded(const std::string& file, const std::string& protocol) const {
        std::istringstream lines(
            run("\"$TRIBUS\" decode --format json --protocol " + protocol + " " + file));
        std::vector<Sent> frames;
        for (std::string line; std::getline(lines, line);) {
            const auto json = nlohmann::json::parse(line);
            if (!json.contains("channels")) {
                continue;
            }
            Sent& frame = frames.emplace_back();
            frame.at = json["t_us"];
            for (const auto& channel : json["channels"]) {
                frame.channels.push_back(channel.is_null() ? std::nullopt
                                                           : std::optional<double>(channel));
            }
            frame.frame_lost = json["frame_lost"];
            frame.failsafe = json["failsafe"];
        }
        return frames;
    }

    TemporaryFolder folder_;
};

/// What a reader gets before, at and after the loss of the receiver: failsafe, control, values that
/// are held and marked, failsafe. `hold_from`, `failsafe_from`: us after the last frame.
/// `flagged`: held values have the failsafe flag, too.
void expect_marked_loss(const std::vector<Sent>& frames, const Pulses& values,
                        const Pulses& presets, std::int64_t hold_from, std::int64_t failsafe_from,
                        bool flagged = false) {
    constexpr std::int64_t kPeriod = 25'000;  // us; the longest of these outputs, and some more
    constexpr std::int64_t kPowerOn = 500'000;
    std::size_t good = 0;
    std::size_t held = 0;
    std::size_t failsafe = 0;
    for (const Sent& frame : frames) {
        SCOPED_TRACE(frame.at);
        const bool holds =
            frame.frame_lost && (flagged ? frame.channels == values : !frame.failsafe);
        EXPECT_EQ(frame.channels, frame.failsafe && !holds ? presets : values);
        if (frame.at < kPowerOn || frame.at > kLastStick + failsafe_from + kPeriod) {
            EXPECT_TRUE(frame.failsafe);
        } else if (frame.at > kPowerOn + 2 * kPeriod &&
                   frame.at < kLastStick + hold_from - kPeriod) {
            EXPECT_TRUE(frame.good());
        } else if (frame.at > kLastStick + hold_from + kPeriod &&
                   frame.at < kLastStick + failsafe_from - kPeriod) {
            EXPECT_TRUE(holds && frame.failsafe == flagged);
        }
        good += frame.good() ? 1U : 0U;
        held += holds ? 1U : 0U;
        failsafe += frame.failsafe && !holds ? 1U : 0U;
    }
    EXPECT_GT(good, 20U);
    EXPECT_GT(held, 3U);
    EXPECT_GT(failsafe, 30U);
}

const Pulses kStandstill = pulses({1500, 1500, 988, 1500, 1500, 1500, 1500, 1500, 1500, 1500, 1500,
                                   1500, 1500, 1500, 1500, 1500});

TEST_F(SimulatedExample, CrsfToMavlinkCarriesSixteenChannelsAndMarksALoss) {
    make_receiver("crsf");
    simulate("crsf-to-mavlink", "--in radio=receiver.txt --out autopilot=out.txt");
    constexpr bool kFlagged = true;
    expect_marked_loss(decoded("out.txt", "mavlink"), pulses(kSticks), kStandstill, 250'000,
                       400'000, kFlagged);
}

TEST_F(SimulatedExample, CrsfToDroneCanCarriesSixteenChannelsAndMarksALoss) {
    make_receiver("crsf");
    simulate("crsf-to-dronecan", "--in radio=receiver.txt --out autopilot=out.log");
    expect_marked_loss(decoded("out.log", "dronecan --scale us"), pulses(kSticks), kStandstill,
                       250'000, 400'000);
}

/// Lines of a recording that has `bytes` each 100 ms for 2 s.
std::string repeated(const Bytes& bytes) {
    std::string lines;
    for (int number = 0; number < 20; ++number) {
        lines += fmt::format("{} {:02x}\n", number * 100'000, fmt::join(bytes, " "));
    }
    return lines;
}

TEST_F(SimulatedExample, CrsfToMavlinkShowsBatteryAndPositionOnTheHandset) {
    // The payloads of BATTERY_STATUS and GPS_RAW_INT are written by hand from common.xml: 12 V in
    // one cell, 10 A, 64 %; 48.1371536 and -11.5753822 degrees, 519.123 m, 12.34 m/s, 14
    // satellites.
    Bytes battery =
        from_hex("dc050000 ffffffff f609 e02e ffffffffffffffffffffffffffffffffffff e803");
    append(battery, from_hex("00 00 00 40"));
    const Bytes position =
        from_hex("0000000000000000 9025b11c a2bc19f9 d3eb0700 ffff ffff d204 0e6a 03 0e");
    Bytes messages = message_2(147, 154, battery);
    append(messages, message_2(24, 24, position));
    folder_.write("copter.txt", repeated(messages));
    simulate("crsf-to-mavlink", "--in copter=copter.txt --out handset=out.txt");
    const std::string said = folder_.read("out.txt");
    // docs/protocols/crsf.md, "Telemetry": 120 and 100 tenths, 0 mAh, 64 %; then the position, 444
    // tenths of km/h, no heading, 1519 m, 14.
    EXPECT_NE(said.find(" c8 0a 08 00 78 00 64 00 00 00 40 "), std::string::npos) << said;
    EXPECT_NE(said.find(" c8 11 02 1c b1 25 90 f9 19 bc a2 01 bc 00 00 05 ef 0e "),
              std::string::npos)
        << said;
}

TEST_F(SimulatedExample, CrsfToDroneCanShowsTheBatteryOnTheHandset) {
    // "batteryinfo" of tests/vectors/dronecan_vectors.json: 16.5 V, 12.25 A, 68 %.
    folder_.write("pack.log",
                  "(1.000000) can0 1004441E#23F9A85C204C2086\n"
                  "(1.000200) can0 1004441E#4A505A4052A05426\n"
                  "(1.000400) can0 1004441E#0000011FE2030006\n"
                  "(1.000600) can0 1004441E#000000006C697026\n"
                  "(1.000800) can0 1004441E#6F347346\n");
    simulate("crsf-to-dronecan", "--in pack=pack.log --out handset=out.txt");
    const std::string said = folder_.read("out.txt");
    EXPECT_NE(said.find(" c8 0a 08 00 a5 00 7b 00 00 00 44 "), std::string::npos) << said;
}

// --- The joystick of ROS 2 -----------------------------------------------------------------------

/// A report as docs/protocols/joystick.md has it: two bytes of buttons that matter, two axes.
struct Report {
    std::int64_t at = 0;  ///< us
    unsigned buttons = 0;
    int steering = 0;
    int speed = 0;
    bool others_rest = true;
};

std::vector<Report> reports_in(const std::string& text) {
    constexpr unsigned kCentre = 1024;
    std::istringstream lines(text);
    std::vector<Report> reports;
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("#")) {
            continue;
        }
        std::istringstream words(line);
        Report& report = reports.emplace_back();
        words >> report.at;
        std::vector<unsigned> bytes;
        for (unsigned byte = 0; words >> std::hex >> byte;) {
            bytes.push_back(byte);
        }
        EXPECT_EQ(bytes.size(), 19U) << line;
        bytes.resize(19);
        const auto axis = [&](std::size_t number) {
            return bytes[3 + 2 * number] | bytes[4 + 2 * number] << 8U;
        };
        report.buttons = bytes[0] | bytes[1] << 8U | bytes[2] << 16U;
        report.steering = static_cast<int>(axis(0));
        report.speed = static_cast<int>(axis(1));
        for (std::size_t number = 2; number < 8; ++number) {
            report.others_rest = report.others_rest && axis(number) == kCentre;
        }
    }
    return reports;
}

TEST_F(SimulatedExample, IbusToRosReleasesTheLinkAndCentresAllAxesOnALoss) {
    constexpr unsigned kLinkAndEnable = 3;
    constexpr int kCentre = 1024;
    constexpr std::int64_t kTimeout = 100'000;  // us; then at once, for nothing is held
    constexpr std::int64_t kPeriod = 20'000;
    make_receiver("ibus");
    simulate("ibus-to-ros", "--in receiver=receiver.txt --out robot=out.txt");
    std::size_t controlled = 0;
    std::size_t released = 0;
    for (const Report& report : reports_in(folder_.read("out.txt"))) {
        SCOPED_TRACE(report.at);
        EXPECT_TRUE(report.others_rest);
        if (report.buttons == 0) {
            ++released;
            EXPECT_EQ(report.steering, kCentre);
            EXPECT_EQ(report.speed, kCentre);
        } else {
            ++controlled;
            EXPECT_EQ(report.buttons, kLinkAndEnable);
            // Two steps a microsecond from 988 us on; 1700 us, and 1600 us reversed.
            EXPECT_EQ(report.steering, 2 * (1700 - 988));
            EXPECT_EQ(report.speed, 2 * (1400 - 988));
            EXPECT_LT(report.at, kLastStick + kTimeout + kPeriod);
        }
    }
    EXPECT_GT(controlled, 50U);
    EXPECT_GT(released, 50U);
}

TEST_F(SimulatedExample, IbusToRosReleasesTheEnableButtonAloneWhenItsSwitchIsOff) {
    folder_.write("sticks.jsonl", [] {
        std::string lines;
        for (int at = 0; at < 1'000'000; at += 7700) {
            lines += fmt::format("{{\"t_us\":{},\"channels\":[1500,1500,1500,1500,1000]}}\n", at);
        }
        return lines;
    }());
    run("\"$TRIBUS\" encode --protocol ibus --format timed sticks.jsonl > receiver.txt");
    simulate("ibus-to-ros", "--in receiver=receiver.txt --out robot=out.txt");
    std::size_t controlled = 0;
    for (const Report& report : reports_in(folder_.read("out.txt"))) {
        EXPECT_EQ(report.buttons & 2U, 0U) << report.at;
        controlled += report.buttons & 1U;
    }
    EXPECT_GT(controlled, 50U);
}

// --- The gamepad ---------------------------------------------------------------------------------

/// A report of a gamepad, by docs/protocols/gamepad.md: sticks at fixed places, pressed buttons.
std::string gamepad_report(std::int64_t at, const std::vector<int>& pressed) {
    struct Axis {
        int code;
        int position;
    };
    Bytes bytes{0x67, 2, 4, static_cast<std::uint8_t>(pressed.size())};
    for (const Axis& axis : {Axis{0, 300}, {1, -32767}, {3, 16384}, {4, 0}}) {
        append(bytes,
               Bytes{static_cast<std::uint8_t>(axis.code), static_cast<std::uint8_t>(axis.position),
                     static_cast<std::uint8_t>(axis.position >> 8)});
    }
    for (const int code : pressed) {
        append(bytes, Bytes{static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(code >> 8)});
    }
    return fmt::format("{} {:02x}\n", at, fmt::join(bytes, " "));
}

TEST_F(SimulatedExample, GamepadToCrsfSendsChannelsOnlyWhileItsHandleIsPressed) {
    constexpr int kHandle = 0x136;  // BTN_TL
    constexpr int kSouth = 0x130;   // BTN_SOUTH
    constexpr std::int64_t kReleased = 1'500'000;
    constexpr std::int64_t kPressedAgain = 2'500'000;
    constexpr std::int64_t kPeriod = 20'000;
    constexpr std::int64_t kPowerOn = 500'000;
    std::string reports;
    for (std::int64_t at = 0; at < 4'000'000; at += kPeriod) {
        const bool pressed = at < kReleased || at >= kPressedAgain;
        reports += gamepad_report(at, pressed ? std::vector{kHandle, kSouth} : std::vector<int>{});
    }
    folder_.write("pad.txt", reports);
    simulate("gamepad-to-crsf-udp", "--in pad=pad.txt --out machine=out.txt");
    std::size_t before = 0;
    std::size_t after = 0;
    std::size_t silent = 0;
    for (const Sent& frame : decoded("out.txt", "crsf")) {
        SCOPED_TRACE(frame.at);
        if (frame.failsafe) {
            EXPECT_EQ(frame.channels, Pulses(18)) << "a radio that is lost has no channels";
            silent += frame.at > kReleased && frame.at < kPressedAgain ? 1U : 0U;
            continue;
        }
        EXPECT_TRUE(frame.at < kReleased + kPeriod || frame.at > kPressedAgain + kPowerOn);
        before += frame.at < kReleased + kPeriod ? 1U : 0U;
        after += frame.at > kPressedAgain ? 1U : 0U;
        // The deadband takes the 5 us off the centre, and 20 of 250 us from the right stick.
        EXPECT_NEAR(frame.channels.at(0).value_or(0), 1740, 2);
        EXPECT_NEAR(frame.channels.at(1).value_or(0), 1500, 1);
        EXPECT_NEAR(frame.channels.at(2).value_or(0), 2000, 1);
        EXPECT_NEAR(frame.channels.at(3).value_or(0), 1500, 1);
        EXPECT_NEAR(frame.channels.at(4).value_or(0), 2000, 1);
    }
    EXPECT_GT(before, 40U);
    EXPECT_GT(after, 30U);
    EXPECT_GT(silent, 8U);
}

}  // namespace
}  // namespace tribus::test::simulate_examples_test
