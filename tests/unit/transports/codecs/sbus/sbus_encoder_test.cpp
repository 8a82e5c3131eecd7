#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "tests/support/sbus_frames.h"
#include "tests/support/streams.h"
#include "transports/codecs/sbus/sbus.h"

namespace tribus::sbus_encoder_test {
namespace {

using namespace test;

Bytes emit(const SbusFrame& frame) {
    Bytes wire(kSbusFrameLength);
    emit_sbus(frame, std::span(wire).first<kSbusFrameLength>());
    return wire;
}

Bytes encoded(const ChannelFrame& frame) {
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = SbusEncoder().write(frame, wire, Instant{});
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}

TEST(SbusFrame, ReadsPublishedFrames) {
    EXPECT_EQ(raw_values(parse(kAll992)), RawValues(16, 992));
    EXPECT_EQ(raw_values(parse(kAll1024)), RawValues(16, 1024));
    RawValues hundreds;
    for (int value = 100; value <= 1600; value += 100) {
        hundreds.push_back(value);
    }
    EXPECT_EQ(raw_values(parse(kHundreds)), hundreds);
    EXPECT_EQ(raw_values(parse(kFrsky)), (RawValues{997, 992, 992, 992, 992, 992, 992, 992, 992,
                                                    192, 992, 192, 985, 992, 992, 992}));
    EXPECT_EQ(parse(kFasstest14).footer, 0x04);
    EXPECT_EQ(parse(kFasstest12).footer, 0x08);
    EXPECT_EQ(parse(kTfr8sb).footer, 0x00);
}

TEST(SbusFrame, WritesPublishedFramesByteForByte) {
    for (const std::string_view hex :
         {kAll992, kAll1024, kHundreds, kFasstest14, kFasstest12, kTfr8sb, kFrsky, kUnusedZero}) {
        EXPECT_EQ(emit(parse(hex)), from_hex(hex));
    }
}

TEST(SbusFrame, EveryValueOfEveryChannelHasItsOwnBits) {
    for (const std::uint16_t others : std::array<std::uint16_t, 2>{0, kSbusRawMost}) {
        for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
            for (std::uint16_t value = 0; value <= kSbusRawMost; ++value) {
                SbusFrame frame;
                frame.raw.fill(others);
                frame.raw[channel] = value;
                const Bytes wire = emit(frame);
                ASSERT_EQ(parse_sbus(std::span(wire).first<kSbusFrameLength>()), frame);
                // docs/protocols/sbus.md, "Frame": bit k of channel c is bit (11 c + k) mod 8 of
                // byte 1 + (11 c + k) div 8.
                for (std::size_t bit = 0; bit < 11; ++bit) {
                    const std::size_t place = 11 * channel + bit;
                    ASSERT_EQ(wire[1 + place / 8] >> place % 8 & 1, value >> bit & 1);
                }
            }
        }
    }
}

TEST(SbusFrame, EachFlagHasItsBit) {
    for (unsigned flags = 0; flags < 16; ++flags) {
        SbusFrame frame;
        frame.channel_17 = (flags & 1U) != 0;
        frame.channel_18 = (flags & 2U) != 0;
        frame.frame_lost = (flags & 4U) != 0;
        frame.failsafe = (flags & 8U) != 0;
        const Bytes wire = emit(frame);
        EXPECT_EQ(wire[23], flags);
        EXPECT_EQ(parse_sbus(std::span(wire).first<kSbusFrameLength>()), frame);
    }
}

TEST(SbusEncoder, WritesFlagsFooterAndSwitches) {
    for (unsigned flags = 0; flags < 16; ++flags) {
        ChannelFrame frame;
        frame.set(16, (flags & 1U) != 0 ? kSwitchOnPulse : kSwitchOffPulse);
        frame.set(17, (flags & 2U) != 0 ? kSwitchOnPulse : kSwitchOffPulse);
        frame.frame_lost = (flags & 4U) != 0;
        frame.failsafe = (flags & 8U) != 0;
        const Bytes wire = encoded(frame);
        ASSERT_EQ(wire.size(), kSbusFrameLength);
        EXPECT_EQ(wire[0], 0x0F);
        EXPECT_EQ(wire[23], flags);
        EXPECT_EQ(wire[24], 0x00);
    }
}

TEST(SbusEncoder, ASwitchIsOnAboveTheCentre) {
    constexpr Pulse kJustAbove = Pulse::from_eighths(kCentrePulse.eighths() + 1);
    ChannelFrame frame;
    frame.frame_lost = frame.failsafe = false;
    frame.set(16, kCentrePulse);
    frame.set(17, kJustAbove);
    EXPECT_EQ(encoded(frame)[23], 0x02);
    frame.set(16, kJustAbove);
    frame.set(17, kCentrePulse);
    EXPECT_EQ(encoded(frame)[23], 0x01);
}

TEST(SbusEncoder, SendsEachAbsentChannelAsCentreOrOffAndTheOthersAsTheyAre) {
    for (std::uint32_t absent = 0; absent <= kAllChannels; absent += 37) {
        ChannelFrame frame;
        ChannelFrame full;
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            const Pulse pulse = Pulse::from_eighths(8 * (1100 + 50 * static_cast<int>(channel)));
            const bool missing = ((absent >> channel) & 1U) != 0;
            frame.set(channel, missing ? std::nullopt : std::optional(pulse));
            full.set(channel, !missing                  ? pulse
                              : channel < kSbusChannels ? kCentrePulse
                                                        : kSwitchOffPulse);
        }
        ASSERT_EQ(encoded(frame), encoded(full)) << absent;
    }
}

TEST(SbusEncoder, SendsAbsentChannelsAsCentreAndOff) {
    ChannelFrame frame;
    frame.frame_lost = frame.failsafe = false;
    EXPECT_EQ(encoded(frame), from_hex(kAll992));
}

TEST(SbusEncoder, ClampsWhatElevenBitsDoNotHold) {
    ChannelFrame frame;
    frame.set(0, Pulse::from_eighths(-32768));
    frame.set(1, Pulse::from_eighths(32767));
    const Bytes wire = encoded(frame);
    const SbusFrame read = parse_sbus(std::span(wire).first<kSbusFrameLength>());
    EXPECT_EQ(read.raw[0], 0);
    EXPECT_EQ(read.raw[1], 2047);
}

TEST(SbusProtocol, MakesBothWithTheScaleOfItsSettings) {
    SettingValues settings;
    settings.set("scale", std::string("px4"));
    const auto decoder = make_byte_decoder(kSbusProtocol, settings);
    FrameEncoder encoder(kSbusProtocol.make_encoder(settings));
    ChannelFrame frame;
    frame.set(0, kCentrePulse);
    const auto wire = encoder.encode(frame, Instant{}).bytes();
    EXPECT_LE(wire.size(), kSbusProtocol.longest_frame);
    EXPECT_EQ(parse_sbus(wire.first<kSbusFrameLength>()).raw[0], 1002);
    feed(*decoder, wire);
    EXPECT_EQ(decoder->finish()->channels.channel(0)->whole_microseconds(), 1500);
}

// docs/protocols/sbus.md, "Periods" and "Synchronisation": 3 ms of frame and 4 ms of silence.
TEST(SbusProtocol, LeavesTheSilenceThatReadersWaitFor) {
    EXPECT_GE(kSbusProtocol.least_period,
              kSbusProtocol.line.bytes_time(kSbusFrameLength) + std::chrono::milliseconds(4));
    EXPECT_TRUE(kSbusProtocol.signals_failsafe({}));
    EXPECT_TRUE(kSbusProtocol.line.inverted_wire);
}

}  // namespace
}  // namespace tribus::sbus_encoder_test
