#include <chrono>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <random>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/cli/exit_status.h"
#include "app/cli/protocol_use.h"
#include "app/wire/encode.h"
#include "app/wire/frames/waveform.h"
#include "tests/support/shell.h"

/// Compares with an independent reader: the uart decoder of sigrok reads the waveform of `encode
/// --format vcd` and must find the bytes that `encode` writes.
namespace tribus::sigrok_test {
namespace {

using test::run_in_shell;
using test::TemporaryFolder;

using Bytes = std::vector<std::uint8_t>;

struct Heard {
    Bytes bytes;
    std::vector<std::string> complaints;
};

/// Decodes at 10 MHz, which is 50 samples of the shortest bit and much faster than using each unit.
Heard hear(const std::string& dump, const LineSettings& line) {
    const TemporaryFolder folder;
    std::istringstream lines(
        run_in_shell(
            fmt::format(
                "sigrok-cli -I vcd:downsample=10 -i '{}' -P uart:rx=wire:baudrate={}:parity={}:"
                "stop_bits=1.0:invert_rx={} -A uart=rx-data:rx-parity-err:rx-warnings",
                folder.write("wave.vcd", dump), line.baud,
                line.parity == Parity::even ? "even" : "none", line.inverted_wire ? "yes" : "no"))
            .output);
    Heard heard;
    for (std::string text; std::getline(lines, text);) {
        constexpr std::string_view kPrefix = "uart-1: ";
        const bool byte =
            text.size() == kPrefix.size() + 2 && text.starts_with(kPrefix) &&
            text.find_first_not_of("0123456789ABCDEF", kPrefix.size()) == std::string::npos;
        if (byte) {
            heard.bytes.push_back(
                static_cast<std::uint8_t>(std::stoul(text.substr(kPrefix.size()), nullptr, 16)));
        } else {
            heard.complaints.push_back(text);
        }
    }
    return heard;
}

std::string encoded(const std::string& lines, const ProtocolUse& use, EncodeFormat format) {
    std::istringstream input(lines);
    std::ostringstream results;
    EXPECT_EQ(encode_lines(input, "frames", use, format, results, std::cerr), kExitFine);
    return results.str();
}

ProtocolUse use_of(std::string_view protocol, const GivenSettings& given) {
    const auto uses = choose_protocols(protocol, SettingScope::output, given);
    EXPECT_TRUE(uses) << uses.error();
    return uses->front();
}

std::string frame_line(const std::vector<double>& pulses, bool frame_lost, bool failsafe) {
    return fmt::format("{{\"channels\":[{}],\"frame_lost\":{},\"failsafe\":{}}}\n",
                       fmt::join(pulses, ","), frame_lost, failsafe);
}

/// Every raw value of SBUS once, 16 in a frame, with all states of the four flags; then noise.
std::string sbus_frames() {
    std::string lines;
    std::vector<double> pulses(18);
    for (unsigned frame = 0; frame < 2048 / 16; ++frame) {
        for (unsigned channel = 0; channel < 16; ++channel) {
            pulses[channel] = 880 + 0.625 * (frame + 128 * channel);
        }
        pulses[16] = (frame & 1U) != 0 ? 2000 : 1000;
        pulses[17] = (frame & 2U) != 0 ? 2000 : 1000;
        lines += frame_line(pulses, (frame & 4U) != 0, (frame & 8U) != 0);
    }
    std::mt19937 random(1);
    for (unsigned frame = 0; frame < 32; ++frame) {
        for (double& pulse : pulses) {
            pulse = 880 + 0.625 * static_cast<double>(random() % 2048);
        }
        lines += frame_line(pulses, false, false);
    }
    return lines;
}

std::string ibus_frames() {
    std::string lines;
    std::vector<double> pulses(18);
    std::mt19937 random(2);
    for (unsigned frame = 0; frame < 100; ++frame) {
        for (double& pulse : pulses) {
            pulse = static_cast<double>(random() % 4096);
        }
        lines += frame_line(pulses, false, false);
    }
    return lines;
}

class Sigrok : public testing::Test {
  protected:
    void SetUp() override {
        if (run_in_shell("command -v sigrok-cli").status != 0) {
            GTEST_SKIP() << "sigrok-cli is not installed (Debian: sigrok-cli)";
        }
    }
};

void expect_heard_as_sent(const std::string& lines, const ProtocolUse& use) {
    const std::string sent = encoded(lines, use, EncodeFormat::binary);
    ASSERT_FALSE(sent.empty());
    const Heard heard = hear(encoded(lines, use, EncodeFormat::vcd), use.line);
    EXPECT_EQ(heard.complaints, std::vector<std::string>{});
    EXPECT_EQ(heard.bytes, Bytes(sent.begin(), sent.end()));
}

TEST_F(Sigrok, HearsSbus) {
    expect_heard_as_sent(sbus_frames(), use_of("sbus", {}));
}

TEST_F(Sigrok, HearsFastSbus) {
    expect_heard_as_sent(sbus_frames(), use_of("sbus", {{"baud", "200000"}}));
}

TEST_F(Sigrok, HearsIbus) {
    expect_heard_as_sent(ibus_frames(), use_of("ibus", {{"channels", "18"}}));
}

std::string wave_of(const Bytes& bytes, const LineSettings& line) {
    Waveform waveform(line);
    std::string dump;
    waveform.begin(dump, std::chrono::milliseconds(1));
    waveform.frame(dump, std::chrono::milliseconds(1), bytes);
    waveform.end(dump);
    return dump;
}

// 0x03 has an even number of ones. With three stop bits there is a one in the place of the parity
// bit.
TEST_F(Sigrok, ComplainsOfWrongParity) {
    const LineSettings sbus = use_of("sbus", {}).line;
    LineSettings wrong = sbus;
    wrong.parity = Parity::none;
    wrong.stop_bits = 3;
    EXPECT_EQ(hear(wave_of({0x03}, sbus), sbus).complaints.size(), 0U);
    EXPECT_GT(hear(wave_of({0x03}, wrong), sbus).complaints.size(), 0U);
}

// Four bits into the next byte: at this rate its start bit is in the place of the stop bit.
TEST_F(Sigrok, ComplainsOfAWrongRate) {
    const LineSettings sbus = use_of("sbus", {}).line;
    LineSettings wrong = sbus;
    wrong.baud = 115200;
    EXPECT_GT(hear(wave_of({0x00, 0x00, 0xFF}, wrong), sbus).complaints.size(), 0U);
}

// Reads an inverted wire as if it were not inverted.
TEST_F(Sigrok, DoesNotHearAnInvertedWireAsAStraightOne) {
    const LineSettings sbus = use_of("sbus", {}).line;
    LineSettings straight = sbus;
    straight.inverted_wire = false;
    const Bytes bytes{0x0F, 0xE0, 0x03};
    EXPECT_EQ(hear(wave_of(bytes, sbus), sbus).bytes, bytes);
    EXPECT_NE(hear(wave_of(bytes, sbus), straight).bytes, bytes);
}

}  // namespace
}  // namespace tribus::sigrok_test
