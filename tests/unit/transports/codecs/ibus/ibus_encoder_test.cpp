#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/ibus_frames.h"
#include "tests/support/streams.h"
#include "transports/codecs/ibus/ibus.h"

namespace tribus::ibus_encoder_test {
namespace {

using namespace test;

Bytes encoded(IbusEncoder&& encoder, const ChannelFrame& frame) {
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = encoder.write(frame, wire, Instant{});
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}

ChannelFrame frame_of(int microseconds) {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        frame.set(channel, Pulse::from_microseconds(microseconds + static_cast<int>(channel)));
    }
    return frame;
}

TEST(IbusEncoder, WritesThePublishedFramesByteForByte) {
    for (const std::string_view hex : {kIa6bFrame, kIa6bFrame2015, kArduPilotFrame}) {
        const auto frame = decode_one(from_hex(hex));
        ASSERT_TRUE(frame);
        EXPECT_EQ(encoded(IbusEncoder(14), *frame), from_hex(hex));
    }
    const auto frame = decode_one(from_hex(kFtr8bFrame));
    ASSERT_TRUE(frame);
    EXPECT_EQ(encoded(IbusEncoder(18), *frame), from_hex(kFtr8bFrame));
}

// docs/protocols/ibus.md, "Loss of signal": ArduPilot takes a nonzero nibble in slot 1 or 4 for
// failsafe.
TEST(IbusEncoder, FourteenChannelsHaveNoNibble) {
    const Bytes wire = encoded(IbusEncoder(14), frame_of(2000));
    for (std::size_t slot = 0; slot < 14; ++slot) {
        EXPECT_EQ(wire[3 + 2 * slot] & 0xF0, 0);
    }
}

TEST(IbusEncoder, WritesEveryMicrosecondOfEveryChannel) {
    for (int base = 0; base < 4096; ++base) {
        ChannelFrame frame;
        std::vector<int> expected;
        for (int channel = 0; channel < 18; ++channel) {
            const int value = (base + 227 * channel) % 4096;
            frame.set(static_cast<std::size_t>(channel), Pulse::from_microseconds(value));
            expected.push_back(channel >= 14 && value == 0 ? -1 : value);
        }
        const auto eighteen = decode_one(encoded(IbusEncoder(18), frame));
        ASSERT_TRUE(eighteen);
        ASSERT_EQ(whole_microseconds(*eighteen), expected);
        const auto fourteen = decode_one(encoded(IbusEncoder(14), frame));
        ASSERT_TRUE(fourteen);
        expected.resize(14);
        expected.resize(18, -1);
        ASSERT_EQ(whole_microseconds(*fourteen), expected);
    }
}

TEST(IbusEncoder, RoundsToWholeMicrosecondsAndClampsToTwelveBits) {
    ChannelFrame frame;
    frame.set(0, Pulse::from_eighths(12003));
    frame.set(1, Pulse::from_eighths(12004));
    frame.set(2, Pulse::from_eighths(-32768));
    frame.set(3, Pulse::from_eighths(32767));
    frame.set(14, Pulse::from_eighths(32767));
    const auto decoded = decode_one(encoded(IbusEncoder(18), frame));
    ASSERT_TRUE(decoded);
    EXPECT_EQ(decoded->channel(0), Pulse::from_microseconds(1500));
    EXPECT_EQ(decoded->channel(1), Pulse::from_microseconds(1501));
    EXPECT_EQ(decoded->channel(2), Pulse::from_microseconds(0));
    EXPECT_EQ(decoded->channel(3), Pulse::from_microseconds(4095));
    EXPECT_EQ(decoded->channel(14), Pulse::from_microseconds(4095));
}

TEST(IbusEncoder, SendsAbsentChannelsAsReceiversDo) {
    const auto decoded = decode_one(encoded(IbusEncoder(18), ChannelFrame{}));
    ASSERT_TRUE(decoded);
    for (std::size_t channel = 0; channel < 14; ++channel) {
        EXPECT_EQ(decoded->channel(channel), kCentrePulse);
    }
    for (std::size_t channel = 14; channel < kChannelCount; ++channel) {
        EXPECT_FALSE(decoded->has(channel));
    }
}

TEST(IbusEncoder, FlagsDoNotChangeTheWire) {
    ChannelFrame frame = frame_of(1500);
    frame.failsafe = frame.frame_lost = true;
    ChannelFrame good = frame;
    good.failsafe = good.frame_lost = false;
    EXPECT_EQ(encoded(IbusEncoder(18), frame), encoded(IbusEncoder(18), good));
}

TEST(IbusProtocol, MakesWhatItsSettingsSay) {
    SettingValues settings;
    settings.set("slots", std::string("plain"));
    settings.set("channels", std::int64_t{18});
    const auto decoder = make_byte_decoder(kIbusProtocol, settings);
    FrameEncoder encoder(kIbusProtocol.make_encoder(settings));
    const auto wire = encoder.encode(frame_of(1500), Instant{}).bytes();
    EXPECT_LE(wire.size(), kIbusProtocol.longest_frame);
    const auto frames = feed(*decoder, wire);
    ASSERT_EQ(frames.size(), 1U);
    // 1514 is 0x5EA. A reader of plain slots sees its nibble A in bits 12 to 15 of slot 1.
    EXPECT_EQ(frames[0].channels.channel(0), Pulse::from_microseconds(0xA000 + 1500));
    EXPECT_FALSE(frames[0].channels.has(14));
}

TEST(IbusProtocol, ReadsNibblesAndWritesFourteenChannelsByDefault) {
    const auto decoder = make_byte_decoder(kIbusProtocol, {});
    FrameEncoder encoder(kIbusProtocol.make_encoder({}));
    EXPECT_EQ(feed(*decoder, from_hex(kFtr8bFrame))[0].channels.channel(17), kCentrePulse);
    EXPECT_EQ(encoder.encode(frame_of(1500), Instant{}).bytes()[3] & 0xF0, 0);
}

TEST(IbusProtocol, LeavesTimeForAWholeFrame) {
    EXPECT_LT(kIbusProtocol.line.bytes_time(kIbusProtocol.longest_frame),
              kIbusProtocol.least_period);
    EXPECT_FALSE(kIbusProtocol.signals_failsafe({}));
}

}  // namespace
}  // namespace tribus::ibus_encoder_test
