#include "transports/codecs/dronecan/rc.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "tests/support/dronecan_frames.h"

namespace tribus::dronecan::rc_encoder_test {
namespace {

using namespace test;
using std::chrono::milliseconds;

/// docs/protocols/can.md, "DroneCAN: worked examples", example 2.
const std::vector<CanFrame> kFailsafe = frames_from(
    0x0804742A,
    {"1F670200000DC59F", "DC5843DC5DC5DC3F", "5DC5DC5DC5DC5D1F", "C5DC5DC5DC5DC53F", "DC505F"});

std::optional<ChannelFrame> decoded(RcDecoder& decoder, const std::vector<CanFrame>& frames,
                                    Instant at = kStart) {
    std::optional<ChannelFrame> latest;
    for (const CanFrame& frame : frames) {
        if (const auto snapshot = decoder.next(frame, at)) {
            latest = snapshot;
        }
    }
    return latest;
}

constexpr NodeIdentity kIdentity{42};

std::vector<CanFrame> encoded(RcEncoder& encoder, const ChannelFrame& snapshot) {
    std::array<CanFrame, kMostSnapshotFrames> frames{};
    const std::size_t count = encoder.write(snapshot, frames, kStart);
    return {frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count)};
}

ChannelFrame good_snapshot(std::size_t channels, std::uint32_t sequence = 1) {
    ChannelFrame snapshot;
    for (std::size_t channel = 0; channel < channels; ++channel) {
        snapshot.set(channel, Pulse::from_microseconds(1000 + 50 * static_cast<int>(channel)));
    }
    snapshot.frame_lost = snapshot.failsafe = false;
    snapshot.sequence = sequence;
    return snapshot;
}

RcInput message_in(const std::vector<CanFrame>& frames, bool fd = false) {
    return message_of_frames<RcInput>(frames, fd);
}

TEST(RcInputEncoder, WritesTheBytesOfTheWorkedExample) {
    RcEncoder encoder({.channels = 16, .quality = RcQuality::none});
    encoder.send_as(kIdentity);
    constexpr std::array kPulses{1500, 1500, 900,  1500, 1500, 1500, 1500, 1500,
                                 1500, 1500, 1500, 1500, 1500, 1500, 1500, 1500};
    ChannelFrame snapshot;
    for (std::size_t channel = 0; channel < kPulses.size(); ++channel) {
        snapshot.set(channel, Pulse::from_microseconds(kPulses[channel]));
    }
    // The example has transfer id 31.
    for (int before = 0; before < 31; ++before) {
        encoded(encoder, snapshot);
    }
    EXPECT_EQ(encoded(encoder, snapshot), kFailsafe);
}

TEST(RcInputEncoder, SaysNothingInTheNameOfNobody) {
    RcEncoder encoder({});
    EXPECT_TRUE(encoded(encoder, good_snapshot(18)).empty());
    constexpr NodeIdentity kNone{};
    encoder.send_as(kNone);
    EXPECT_TRUE(encoded(encoder, good_snapshot(18)).empty());
}

TEST(RcInputEncoder, SendsAsManyChannelsAsThereAre) {
    RcEncoder encoder({});
    encoder.send_as(kIdentity);
    EXPECT_EQ(message_in(encoded(encoder, good_snapshot(14))).rcin.size(), 14U);
    EXPECT_EQ(message_in(encoded(encoder, good_snapshot(18))).rcin.size(), 18U);
}

TEST(RcInputEncoder, CutsPulsesThatTheTypeCannotHold) {
    RcEncoder encoder({.channels = 2});
    encoder.send_as(kIdentity);
    ChannelFrame snapshot = good_snapshot(2);
    snapshot.set(0, Pulse::from_microseconds(-100));
    snapshot.set(1, Pulse::from_eighths(32767));
    const RcInput message = message_in(encoded(encoder, snapshot));
    EXPECT_EQ(message.rcin[0], 0);
    EXPECT_EQ(message.rcin[1], 4095);
}

TEST(RcInputEncoder, SetsTheFailsafeFlagAndNoQualityInFailsafe) {
    RcEncoder encoder({});
    encoder.send_as(kIdentity);
    ChannelFrame snapshot = good_snapshot(18);
    snapshot.failsafe = true;
    const RcInput message = message_in(encoded(encoder, snapshot));
    EXPECT_EQ(message.status, RcInput::kFailsafe);
    EXPECT_EQ(message.quality, 0);
}

TEST(RcInputEncoder, MarksHeldValuesWithAValidLinkQualityOfZero) {
    RcEncoder encoder({.quality = RcQuality::none});
    encoder.send_as(kIdentity);
    ChannelFrame snapshot = good_snapshot(18);
    snapshot.frame_lost = true;
    const RcInput message = message_in(encoded(encoder, snapshot));
    EXPECT_EQ(message.status, RcInput::kQualityValid | RcInput::kQualityTypeLinkQuality);
    EXPECT_EQ(message.quality, 0);
}

TEST(RcInputEncoder, TellsTheShareOfTheLatest64FramesThatWereGood) {
    RcEncoder encoder({});
    encoder.send_as(kIdentity);
    std::uint32_t sequence = 0;
    EXPECT_EQ(message_in(encoded(encoder, good_snapshot(18, ++sequence))).quality, 100);
    ChannelFrame lost = good_snapshot(18, ++sequence);
    lost.frame_lost = true;
    encoded(encoder, lost);
    encoded(encoder, lost);  // the same frame again is no further loss
    const RcInput message = message_in(encoded(encoder, good_snapshot(18, ++sequence)));
    EXPECT_EQ(message.status, RcInput::kQualityValid | RcInput::kQualityTypeLinkQuality);
    EXPECT_EQ(message.quality, 98);  // 63 of 64
}

TEST(RcInputEncoder, PassesOnALinkQualityThatItWasToldAndNeverSaysZeroOfAGoodLink) {
    RcEncoder encoder({});
    encoder.send_as(kIdentity);
    ChannelFrame snapshot = good_snapshot(18);
    snapshot.link_quality = 37;
    EXPECT_EQ(message_in(encoded(encoder, snapshot)).quality, 37);
    snapshot.link_quality = 0;
    EXPECT_EQ(message_in(encoded(encoder, snapshot)).quality, 1);
}

TEST(RcInputEncoder, WritesANamedValueInTheUnitOfItsKind) {
    struct Case {
        std::uint16_t type;
        double number;
        std::uint8_t quality;
    };
    for (const auto& [type, number, quality] :
         {Case{RcInput::kQualityTypeLinkQuality, 42, 42}, Case{RcInput::kQualityTypeRssi, 100, 255},
          Case{RcInput::kQualityTypeRssiDbm, -95, 95}, Case{RcInput::kQualityTypeSnr, -7, 121},
          Case{RcInput::kQualityTypeTxPower, 100, 20},
          Case{RcInput::kQualityTypeTxPower, 99999, 255}}) {
        ValueBoard board({{.name = "radio", .unit = "", .lasts = kForever}});
        board.set(0, number, kStart);
        RcEncoder encoder(
            {.quality = RcQuality::value, .quality_type = type, .quality_value = "radio"});
        encoder.send_as(kIdentity);
        encoder.use(board);
        const RcInput message = message_in(encoded(encoder, good_snapshot(18)));
        EXPECT_EQ(message.status, RcInput::kQualityValid | type);
        EXPECT_EQ(message.quality, quality);
    }
}

TEST(RcInputEncoder, TakesAChannelAsAQualityFrom1000To2000Microseconds) {
    ValueBoard board({{.name = "input.main.channel.16", .unit = "us", .lasts = kForever}});
    board.set(0, 1650, kStart);
    RcEncoder encoder({.quality = RcQuality::value, .quality_value = "input.main.channel.16"});
    encoder.send_as(kIdentity);
    encoder.use(board);
    EXPECT_EQ(message_in(encoded(encoder, good_snapshot(18))).quality, 65);
}

TEST(RcInputEncoder, ConvertsTheUnitOfANamedValue) {
    struct Case {
        const char* unit;
        double number;
        std::uint16_t type;
        std::optional<std::uint8_t> quality;
    };
    for (const auto& [unit, number, type, quality] :
         {Case{"ratio", 0.42, RcInput::kQualityTypeLinkQuality, 42},
          Case{"W", 0.1, RcInput::kQualityTypeTxPower, 20},
          Case{"degC", 42, RcInput::kQualityTypeLinkQuality, std::nullopt},
          Case{"bananas", 42, RcInput::kQualityTypeLinkQuality, std::nullopt},
          Case{"us", 1650, RcInput::kQualityTypeSnr, std::nullopt}}) {
        ValueBoard board({{.name = "radio", .unit = unit, .lasts = kForever}});
        board.set(0, number, kStart);
        RcEncoder encoder(
            {.quality = RcQuality::value, .quality_type = type, .quality_value = "radio"});
        encoder.send_as(kIdentity);
        encoder.use(board);
        const RcInput message = message_in(encoded(encoder, good_snapshot(18)));
        EXPECT_EQ((message.status & RcInput::kQualityValid) != 0, quality.has_value()) << unit;
        EXPECT_EQ(message.quality, quality.value_or(0)) << unit;
    }
}

TEST(RcInputEncoder, SaysThatNoQualityIsValidWhereTheNamedValueIsStale) {
    ValueBoard board({{.name = "radio", .unit = "%", .lasts = milliseconds(10)}});
    RcEncoder encoder({.quality = RcQuality::value, .quality_value = "radio"});
    encoder.send_as(kIdentity);
    encoder.use(board);
    EXPECT_EQ(message_in(encoded(encoder, good_snapshot(18))).status, 0);
}

TEST(RcInputEncoder, TakesOneFdFrameOf48BytesFor18Channels) {
    RcEncoder encoder({.fd = true});
    encoder.send_as(kIdentity);
    const auto frames = encoded(encoder, good_snapshot(18));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].length, 48);
    EXPECT_TRUE(frames[0].fd && frames[0].bit_rate_switch && frames[0].extended);
}

TEST(RcInput, GoesThroughEncoderAndDecoderUnchangedToTheMicrosecond) {
    for (const bool fd : {false, true}) {
        for (std::size_t channels = 1; channels <= kChannelCount; ++channels) {
            RcEncoder encoder({.fd = fd});
            encoder.send_as(kIdentity);
            RcDecoder decoder({.fd = fd});
            const ChannelFrame sent = good_snapshot(channels);
            const auto got = decoded(decoder, encoded(encoder, sent));
            ASSERT_TRUE(got) << channels;
            EXPECT_TRUE(got->same_content(sent)) << channels;
        }
    }
}

}  // namespace
}  // namespace tribus::dronecan::rc_encoder_test
