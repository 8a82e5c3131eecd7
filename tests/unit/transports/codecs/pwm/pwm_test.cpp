#include "transports/codecs/pwm/pwm.h"

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "config/build/build.h"
#include "tests/support/channel_bytes.h"
#include "tests/unit/config/main_job.h"
#include "transports/links/pwm/pwm_medium.h"
#include "transports/registry/registry.h"

namespace tribus::test::pwm_test {
namespace {

using Lines = std::vector<std::string>;
using Pulses = std::map<int, std::uint32_t>;

std::string job(const std::string& lines) {
    return "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n"
           "[output.legs]\nprotocol = \"pwm\"\nchip = \"pca9685-pwm\"\n" +
           lines + "[pipeline.main]\nfrom = \"receiver\"\nto = \"legs\"\n";
}

/// The pulses of the chip's outputs, in nanoseconds.
Pulses pulses(const Bytes& bytes) {
    Pulses all;
    for (std::size_t at = 0; at < bytes.size(); at += 5) {
        all[bytes.at(at)] = bytes.at(at + 1) | static_cast<std::uint32_t>(bytes.at(at + 2)) << 8U |
                            static_cast<std::uint32_t>(bytes.at(at + 3)) << 16U |
                            static_cast<std::uint32_t>(bytes.at(at + 4)) << 24U;
    }
    return all;
}

TEST(Pwm, WritesThePulseOfEachChannelToItsOutput) {
    PwmEncoder encoder({{0, 3}, {1, 0}, {17, 15}}, 1);
    std::vector<double> channels(18, 1500);
    channels[0] = 1000;
    channels[1] = 1234.125;
    channels[17] = 2000;
    EXPECT_EQ(pulses(encoded(encoder, frame_of_microseconds(channels))),
              (Pulses{{0, 1234125}, {3, 1000000}, {15, 2000000}}));
    EXPECT_EQ(encoder.needed_channels({}), 1U | 2U | 1U << 17U);
}

TEST(Pwm, LimitsAPulseToWhatServosKnow) {
    PwmEncoder encoder({{0, 0}, {1, 1}}, 1);
    EXPECT_EQ(pulses(encoded(encoder, frame_of_microseconds({-4000, 4000}))),
              (Pulses{{0, 400000}, {1, 2600000}}));
}

// A chip whose oscillator is 3.1 % too fast makes pulses that are too short by as much.
TEST(Pwm, LengthensPulsesForAFastOscillator) {
    PwmEncoder encoder({{0, 0}}, 1.031);
    EXPECT_EQ(pulses(encoded(encoder, frame_of_microseconds({1500}))), (Pulses{{0, 1546500}}));
}

TEST(Pwm, SwitchesEachOutputOffInSilence) {
    PwmEncoder encoder({{0, 3}, {1, 0}}, 1);
    encoded(encoder, frame_of_microseconds({1500, 1500}));
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = encoder.write_silence(wire, {});
    EXPECT_EQ(pulses({wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)}),
              (Pulses{{0, 0}, {3, 0}}));
}

TEST(Pwm, SaysWhatIsWrongInItsTable) {
    EXPECT_EQ(mistakes_in(job("outputs = { 1 = 0, 2 = 1 }\n")), Lines{});
    EXPECT_EQ(mistakes_in(job("outputs = { 19 = 0 }\n")),
              Lines{"t.toml:7:18: unknown; allowed: channels 1 to 18"});
    EXPECT_EQ(mistakes_in(job("outputs = { 1 = -1 }\n")),
              Lines{"t.toml:7:17: allowed: an output of the chip, 0 to 63"});
    EXPECT_EQ(mistakes_in(job("outputs = { 1 = 4, 2 = 4 }\n")),
              Lines{"t.toml:7:24: output 4 has a channel already; allowed: each output once"});
    EXPECT_EQ(mistakes_in(job("outputs = {}\n")),
              Lines{"t.toml:7:11: allowed: at least one channel, such as { 1 = 0 }"});
    EXPECT_EQ(mistakes_in(job("")).size(), 1U) << "outputs is required";
}

TEST(Pwm, GivesItsPeriodToTheChip) {
    const auto period_of = [](const std::string& lines) {
        return plan_ports(loaded(job("outputs = { 1 = 0 }\n" + lines))).at(1).period;
    };
    EXPECT_EQ(period_of(""), std::chrono::milliseconds(20));
    EXPECT_EQ(period_of("period = \"10ms\"\n"), std::chrono::milliseconds(10));
    EXPECT_EQ(media_for(kPwmProtocol), std::vector<const Medium*>{&kPwmMedium});
}

}  // namespace
}  // namespace tribus::test::pwm_test
