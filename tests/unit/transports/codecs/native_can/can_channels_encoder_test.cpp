#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/can_snapshots.h"
#include "tests/support/streams.h"
#include "transports/codecs/native_can/channels.h"

namespace tribus::can_channels_encoder_test {
namespace {

using namespace can_channels;
using namespace test;

Bytes bytes_of(const CanFrame& frame) {
    return {frame.bytes().begin(), frame.bytes().end()};
}

/// Returns the frames of a snapshot that is sent `age` after it was received.
CanFrames encoded(const ChannelFrame& snapshot, const CanChannelsFormat& format = {},
                  Duration age = {}) {
    CanChannelsEncoder encoder(format);
    return can_frames(encoder, snapshot, snapshot.received + age);
}

ChannelFrame with_channel(std::size_t channel, Pulse pulse) {
    ChannelFrame snapshot = numbered_snapshot(0);
    snapshot.set(channel, pulse);
    return snapshot;
}

CanFrame sixth_first_frame(const ChannelFrame& snapshot, const CanChannelsFormat& format) {
    CanChannelsEncoder encoder(format);
    for (int count = 0; count < 5; ++count) {
        can_frames(encoder, snapshot);
    }
    return can_frames(encoder, snapshot).front();
}

// The first of native_vectors in dbc_vectors.json: counter 5, digital 18 on.
TEST(CanChannelsEncoder, WritesThePublishedExampleByteForByte) {
    ChannelFrame snapshot;
    constexpr std::array kMicroseconds{1444.0, 1958.5, 1544.5, 1699.5};
    for (std::size_t channel = 0; channel < kMicroseconds.size(); ++channel) {
        snapshot.set(channel, Pulse::from_fractional_microseconds(kMicroseconds[channel]));
    }
    snapshot.set(17, kSwitchOnPulse);
    snapshot.frame_lost = snapshot.failsafe = false;
    EXPECT_EQ(bytes_of(sixth_first_frame(snapshot, {})), from_hex("bc859057b959f898"));
    EXPECT_EQ(bytes_of(sixth_first_frame(snapshot, {.crc = CanChannelsCrc::p01})),
              from_hex("ee859057b959f898"));
}

TEST(CanChannelsEncoder, SendsFiveFramesInTheOrderOfTheirIds) {
    const CanFrames frames = encoded(numbered_snapshot(1));
    ASSERT_EQ(frames.size(), 5U);
    for (std::size_t part = 0; part < frames.size(); ++part) {
        EXPECT_EQ(frames[part].id, 0x300 + part);
        EXPECT_EQ(frames[part].length, 8);
        EXPECT_FALSE(frames[part].extended || frames[part].fd || frames[part].remote);
    }
}

TEST(CanChannelsEncoder, SendsOneFdFrameWithFastData) {
    const CanFrames frames = encoded(numbered_snapshot(1), {.fd = true});
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].id, 0x305U);
    EXPECT_EQ(frames[0].length, 48);
    EXPECT_TRUE(frames[0].fd);
    EXPECT_TRUE(frames[0].bit_rate_switch);
}

TEST(CanChannelsEncoder, LeavesOutTheFifthFrameWithSixteenChannels) {
    const CanFrames frames = encoded(with_channel(16, kSwitchOnPulse),
                                     {.base_id = 0x1ABCDE00, .extended = true, .channels = 16});
    ASSERT_EQ(frames.size(), 4U);
    EXPECT_EQ(frames[3].id, 0x1ABCDE03U);
    EXPECT_TRUE(frames[3].extended);
    EXPECT_TRUE(parse_can_quad(frames[3].bytes()).status.digital_17);
    EXPECT_FALSE(parse_can_quad(frames[3].bytes()).status.digital_18);
}

TEST(CanChannelsEncoder, TellsTheIdsThatItSends) {
    for (const CanChannelsFormat& format : kCanFormats) {
        CanChannelsEncoder encoder(format);
        const CanChannelsDecoder decoder(format);
        const CanFrames frames = can_frames(encoder, numbered_snapshot(1));
        ASSERT_EQ(encoder.sent().size(), frames.size());
        ASSERT_EQ(decoder.wanted().size(), frames.size());
        for (std::size_t part = 0; part < frames.size(); ++part) {
            EXPECT_TRUE(encoder.sent()[part].matches(frames[part]));
            EXPECT_EQ(encoder.sent()[part], decoder.wanted()[part]);
        }
    }
}

TEST(CanChannelsEncoder, TellsStatesInEveryFrame) {
    ChannelFrame snapshot = numbered_snapshot(1);
    snapshot.failsafe = true;
    for (const CanFrame& frame : encoded(snapshot)) {
        EXPECT_EQ(frame.data[1] & 0x30, 0x10) << frame.id;
    }
    snapshot.failsafe = false;
    snapshot.frame_lost = true;
    for (const CanFrame& frame : encoded(snapshot)) {
        EXPECT_EQ(frame.data[1] & 0x30, 0x20) << frame.id;
    }
    EXPECT_EQ(encoded(snapshot, {.fd = true})[0].data[3] & 0x03, 0x02);
}

std::vector<unsigned> counters(const CanChannelsFormat& format, int snapshots) {
    CanChannelsEncoder encoder(format);
    std::vector<unsigned> values;
    for (int count = 0; count < snapshots; ++count) {
        const CanFrames frames = can_frames(encoder, numbered_snapshot(1));
        values.push_back(get(frames[0].bytes(), format.fd ? kFdCounter : kCounter));
        for (const CanFrame& frame : frames) {
            EXPECT_EQ(get(frame.bytes(), format.fd ? kFdCounter : kCounter), values.back());
        }
    }
    return values;
}

TEST(CanChannelsEncoder, CountsSnapshotsAsFarAsTheProfileGoes) {
    std::vector<unsigned> p22 = counters({}, 18);
    EXPECT_EQ(std::vector(p22.end() - 4, p22.end()), (std::vector{14U, 15U, 0U, 1U}));
    std::vector<unsigned> p01 = counters({.crc = CanChannelsCrc::p01}, 17);
    EXPECT_EQ(std::vector(p01.end() - 4, p01.end()), (std::vector{13U, 14U, 0U, 1U}));
    std::vector<unsigned> p05 = counters({.fd = true}, 258);
    EXPECT_EQ(std::vector(p05.end() - 4, p05.end()), (std::vector{254U, 255U, 0U, 1U}));
}

std::uint16_t classic_raw(double microseconds) {
    return to_wire(kClassicPulse, Pulse::from_fractional_microseconds(microseconds));
}

TEST(CanChannelsEncoder, ClassicPulsesAreTheNearestHalfMicrosecondAndSaturate) {
    EXPECT_EQ(classic_raw(476), 0);
    EXPECT_EQ(classic_raw(476.5), 1);
    EXPECT_EQ(classic_raw(1500), 2048);
    EXPECT_EQ(classic_raw(1500.125), 2048);
    EXPECT_EQ(classic_raw(1500.25), 2048) << "halves go down";
    EXPECT_EQ(classic_raw(1500.375), 2049);
    EXPECT_EQ(classic_raw(2523), 4094);
    EXPECT_EQ(classic_raw(2600), 4094);
    EXPECT_EQ(classic_raw(475.875), 0);
    EXPECT_EQ(classic_raw(-4000), 0);
    EXPECT_EQ(to_wire(kClassicPulse, std::nullopt), 4095);
}

TEST(CanChannelsEncoder, FdPulsesAreExactAndNeverNegative) {
    EXPECT_EQ(to_wire(kFdPulse, Pulse::from_eighths(1)), 1);
    EXPECT_EQ(to_wire(kFdPulse, Pulse::from_eighths(32767)), 32767);
    EXPECT_EQ(to_wire(kFdPulse, Pulse::from_eighths(-1)), 0);
    EXPECT_EQ(to_wire(kFdPulse, Pulse::from_eighths(-32768)), 0);
    EXPECT_EQ(to_wire(kFdPulse, std::nullopt), 0xFFFF);
}

CanChannelsOrigin origin_in(const ChannelFrame& snapshot, Duration age = {}) {
    return parse_can_tail(encoded(snapshot, {}, age)[kTailIndex].bytes()).origin;
}

TEST(CanChannelsEncoder, TellsWhereTheValuesCameFrom) {
    ChannelFrame snapshot = numbered_snapshot(1);
    EXPECT_EQ(origin_in(snapshot).source, 15);
    constexpr std::array kOrigins{Origin::none,     Origin::ibus, Origin::sbus,
                                  Origin::dronecan, Origin::can,  Origin::dbc};
    for (std::size_t source = 0; source < kOrigins.size(); ++source) {
        snapshot.origin = kOrigins[source];
        EXPECT_EQ(origin_in(snapshot).source, source);
    }
}

TEST(CanChannelsEncoder, TellsTheLinkQualityOrThatItHasNone) {
    ChannelFrame snapshot = numbered_snapshot(1);
    EXPECT_EQ(origin_in(snapshot).link_quality, 127);
    snapshot.link_quality = 87;
    EXPECT_EQ(origin_in(snapshot).link_quality, 87);
    snapshot.link_quality = 200;
    EXPECT_EQ(origin_in(snapshot).link_quality, 100);
}

TEST(CanChannelsEncoder, TellsTheHighestChannelThatIsPresent) {
    ChannelFrame snapshot;
    EXPECT_EQ(origin_in(snapshot).channel_count, 0);
    snapshot.set(13, kCentrePulse);
    EXPECT_EQ(origin_in(snapshot).channel_count, 14);
    snapshot.set(17, kCentrePulse);
    EXPECT_EQ(origin_in(snapshot).channel_count, 18);
}

TEST(CanChannelsEncoder, TellsTheAgeInQuarterMilliseconds) {
    const ChannelFrame snapshot = numbered_snapshot(1);
    EXPECT_EQ(origin_in(snapshot, {}).age, 0);
    EXPECT_EQ(origin_in(snapshot, microseconds(2130)).age, 9);
    EXPECT_EQ(origin_in(snapshot, microseconds(63500)).age, 254);
    EXPECT_EQ(origin_in(snapshot, std::chrono::hours(1)).age, 254);
    EXPECT_EQ(origin_in(snapshot, -milliseconds(5)).age, 0);
}

TEST(CanChannelsEncoder, TellsTheAgeInHundredthsOfAMillisecondInFd) {
    const auto age = [](Duration real) {
        return parse_can_fd(encoded(numbered_snapshot(1), {.fd = true}, real)[0].bytes())
            .origin.age;
    };
    EXPECT_EQ(age(microseconds(2130)), 213);
    EXPECT_EQ(age(std::chrono::seconds(2)), 0xFFFE);
}

TEST(CanChannelsEncoder, PresetsOfAnInputThatWasNeverHeardHaveNoAge) {
    ChannelFrame snapshot = numbered_snapshot(1);
    snapshot.received = Instant{};
    CanChannelsEncoder encoder;
    const CanFrames frames = can_frames(encoder, snapshot);
    EXPECT_EQ(parse_can_tail(frames[kTailIndex].bytes()).origin.age, 255);
}

// docs/protocols/can.md, "Native format"; deploy/can/native.dbc. The bytes of each field are
// calculated by hand.
TEST(CanChannelsEncoder, FifthFrameHasItsFieldsWhereTheDbcSays) {
    ChannelFrame snapshot = numbered_snapshot(0);
    snapshot.set(16, Pulse::from_microseconds(476));                // 000
    snapshot.set(17, Pulse::from_fractional_microseconds(2521.5));  // FFB
    snapshot.link_quality = 0x55;
    snapshot.origin = Origin::dronecan;
    const CanFrame frame = encoded(snapshot, {}, milliseconds(2))[kTailIndex];
    EXPECT_EQ(frame.data[1], 0x80);
    EXPECT_EQ(frame.data[2], 0x00);
    EXPECT_EQ(frame.data[3], 0xB0);
    EXPECT_EQ(frame.data[4], 0xFF);
    EXPECT_EQ(frame.data[5], 0x55);  // 18 = 0b10010: its lowest bit is 0
    EXPECT_EQ(frame.data[6], 0x39);
    EXPECT_EQ(frame.data[7], 8);
}

TEST(CanChannelsEncoder, FdFrameHasItsFieldsWhereTheDbcSays) {
    ChannelFrame snapshot = numbered_snapshot(0);
    snapshot.set(0, Pulse::from_eighths(0x1234));
    snapshot.set(17, Pulse::from_eighths(0x5678));
    snapshot.link_quality = 42;
    snapshot.origin = Origin::can;
    const CanFrame frame = encoded(snapshot, {.fd = true}, milliseconds(3))[0];
    EXPECT_EQ(frame.data[2], 0x00);
    EXPECT_EQ(frame.data[3], 0x48);
    EXPECT_EQ(frame.data[4], 18);
    EXPECT_EQ(frame.data[5], 42);
    EXPECT_EQ(frame.data[6], 0x2C);
    EXPECT_EQ(frame.data[7], 0x01);
    EXPECT_EQ(frame.data[8], 0x34);
    EXPECT_EQ(frame.data[9], 0x12);
    EXPECT_EQ(frame.data[42], 0x78);
    EXPECT_EQ(frame.data[43], 0x56);
    for (std::size_t padding = 44; padding < 48; ++padding) {
        EXPECT_EQ(frame.data[padding], 0);
    }
}

SettingValues values(std::int64_t id, bool extended, bool fd, std::string crc,
                     std::int64_t channels) {
    SettingValues settings;
    settings.set("id", id);
    settings.set("extended", extended);
    settings.set("fd", fd);
    settings.set("crc", std::move(crc));
    settings.set("channels", channels);
    return settings;
}

std::vector<std::string> mistaken_keys(const SettingValues& settings) {
    std::vector<std::string> keys;
    for (const SettingMistake& mistake : kCanProtocol.check(settings, SettingScope::both)) {
        keys.push_back(mistake.path.at(0));
        EXPECT_FALSE(mistake.text.empty());
    }
    return keys;
}

TEST(CanProtocol, AllItsIdsMustFitTheirBits) {
    EXPECT_TRUE(mistaken_keys(values(0x7FA, false, false, "p22", 18)).empty());
    EXPECT_EQ(mistaken_keys(values(0x7FB, false, false, "p22", 18)),
              std::vector<std::string>{"id"});
    EXPECT_TRUE(mistaken_keys(values(0x7FB, true, false, "p22", 18)).empty());
}

TEST(CanProtocol, AnFdFrameHasNeitherAnotherCrcNorFewerChannels) {
    EXPECT_TRUE(mistaken_keys(values(0x300, false, true, "p22", 18)).empty());
    EXPECT_EQ(mistaken_keys(values(0x300, false, true, "p01", 16)),
              (std::vector<std::string>{"crc", "channels"}));
}

TEST(CanProtocol, MakesCodecsAsTheSettingsSay) {
    const SettingValues settings = values(0x123, true, false, "p01", 16);
    FrameEncoder encoder(kCanProtocol.make_encoder(settings));
    const auto decoder = make_can_decoder(kCanProtocol, settings);
    ASSERT_EQ(encoder.encoder().sent().size(), 4U);
    ASSERT_EQ(decoder->wanted().size(), 4U);
    EXPECT_EQ(encoder.encoder().sent()[0].id, 0x123U);
    EXPECT_TRUE(encoder.encoder().sent()[0].extended);
    EXPECT_EQ(kCanProtocol.shape, WireShape::can_frames);
    EXPECT_TRUE(kCanProtocol.signals_failsafe(settings));
    const auto frames = encoder.encode(numbered_snapshot(1), can_time({})).can_frames();
    EXPECT_EQ(frames[0].data[0],
              can_channels_crc({.crc = CanChannelsCrc::p01}, 0, frames[0].bytes()));
}

}  // namespace
}  // namespace tribus::can_channels_encoder_test
