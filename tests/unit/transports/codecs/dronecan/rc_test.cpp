#include "transports/codecs/dronecan/rc.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "tests/support/dronecan_frames.h"

namespace tribus::dronecan::rc_test {
namespace {

using namespace test;
using std::chrono::milliseconds;

/// docs/protocols/can.md, "DroneCAN: worked examples", examples 1 and 2: 16 channels of node 42.
const std::vector<CanFrame> kGood = frames_from(
    0x0804742A,
    {"13C30100C80E8385", "4C4B04145785DC25", "5406A460876C7D05", "07DC3DC7DB5DD525", "DE5045"});
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

std::vector<CanFrame> message_of(const RcInput& message, NodeId source = 42,
                                 std::uint8_t transfer_id = 0, bool fd = false) {
    return frames_of_message(message, source, transfer_id, fd);
}

TEST(RcInputDecoder, TakesMicrosecondsAsTheyAre) {
    RcDecoder decoder({});
    const auto snapshot = decoded(decoder, kGood);
    ASSERT_TRUE(snapshot);
    EXPECT_TRUE(snapshot->good());
    EXPECT_EQ(snapshot->origin, Origin::dronecan);
    EXPECT_EQ(snapshot->channel(0), Pulse::from_microseconds(1000));
    EXPECT_EQ(snapshot->channel(11), Pulse::from_microseconds(988));
    EXPECT_EQ(snapshot->channel(15), Pulse::from_microseconds(1502));
    EXPECT_FALSE(snapshot->has(16));
}

TEST(RcInputDecoder, BelievesTheFailsafeFlag) {
    RcDecoder decoder({});
    const auto snapshot = decoded(decoder, kFailsafe);
    ASSERT_TRUE(snapshot);
    EXPECT_TRUE(snapshot->failsafe);
}

TEST(RcInputDecoder, SaysThatValuesAreAsOldAsTheFirstFrameOfTheMessage) {
    RcDecoder decoder({});
    for (std::size_t i = 0; i + 1 < kGood.size(); ++i) {
        EXPECT_FALSE(decoder.next(kGood[i], kStart + milliseconds(i)));
    }
    const auto snapshot = decoder.next(kGood.back(), kStart + milliseconds(4));
    ASSERT_TRUE(snapshot);
    EXPECT_EQ(snapshot->received, kStart);
}

TEST(RcInputDecoder, MarksAValidLinkQualityOfZeroAsFrameLost) {
    RcDecoder decoder({});
    RcInput message;
    message.rcin = {1500};
    message.status = RcInput::kQualityValid | RcInput::kQualityTypeLinkQuality;
    const auto snapshot = decoded(decoder, message_of(message));
    ASSERT_TRUE(snapshot);
    EXPECT_TRUE(snapshot->frame_lost);
    EXPECT_FALSE(snapshot->failsafe);
}

TEST(RcInputDecoder, DoesNotTakeZeroOfOtherKindsOfQualityForALoss) {
    for (const std::uint16_t type :
         {RcInput::kQualityTypeRssiDbm, RcInput::kQualityTypeSnr, RcInput::kQualityTypeTxPower}) {
        RcDecoder decoder({});
        RcInput message;
        message.rcin = {1500};
        message.status = RcInput::kQualityValid | type;
        const auto snapshot = decoded(decoder, message_of(message));
        ASSERT_TRUE(snapshot);
        EXPECT_TRUE(snapshot->good()) << type;
        EXPECT_EQ(snapshot->link_quality, kNoLinkQuality);
    }
}

TEST(RcInputDecoder, TellsTheLinkQualityInPercent) {
    struct Case {
        std::uint16_t type;
        std::uint8_t quality;
        std::uint8_t percent;
    };
    // The highest bit of a link quality selects the antenna. A small RSSI is not an absent one.
    for (const auto& [type, quality, percent] :
         {Case{RcInput::kQualityTypeLinkQuality, 97, 97},
          Case{RcInput::kQualityTypeLinkQuality, 0x80 + 97, 97},
          Case{RcInput::kQualityTypeRssi, 255, 100}, Case{RcInput::kQualityTypeRssi, 1, 1}}) {
        RcDecoder decoder({});
        RcInput message;
        message.rcin = {1500};
        message.status = static_cast<std::uint16_t>(RcInput::kQualityValid | type);
        message.quality = quality;
        const auto snapshot = decoded(decoder, message_of(message));
        ASSERT_TRUE(snapshot);
        EXPECT_EQ(snapshot->link_quality, percent);
        EXPECT_TRUE(snapshot->good());
    }
}

TEST(RcInputDecoder, RemembersALinkQualityThatIsToldInTurnWithOthersForASecond) {
    RcDecoder decoder({});
    RcInput message;
    message.rcin = {1500};
    message.status = RcInput::kQualityValid | RcInput::kQualityTypeLinkQuality;
    message.quality = 80;
    EXPECT_EQ(decoded(decoder, message_of(message, 42, 0))->link_quality, 80);
    message.status = RcInput::kQualityValid | RcInput::kQualityTypeSnr;
    EXPECT_EQ(
        decoded(decoder, message_of(message, 42, 1), kStart + milliseconds(1000))->link_quality,
        80);
    EXPECT_EQ(
        decoded(decoder, message_of(message, 42, 2), kStart + milliseconds(1001))->link_quality,
        kNoLinkQuality);
}

TEST(RcInputDecoder, ReadsRawSbusNumbersWhereTheSenderSendsThem) {
    RcDecoder decoder({.scale = RcScale::sbus});
    RcInput message;
    message.rcin = {992, 192, 1792};
    const auto snapshot = decoded(decoder, message_of(message));
    EXPECT_EQ(snapshot->channel(0), Pulse::from_microseconds(1500));
    EXPECT_EQ(snapshot->channel(1), Pulse::from_microseconds(1000));
    EXPECT_EQ(snapshot->channel(2), Pulse::from_microseconds(2000));
}

TEST(RcInputDecoder, ReadsFullRangeNumbersWhereTheSenderSendsThem) {
    RcDecoder decoder({.scale = RcScale::full_range});
    RcInput message;
    message.rcin = {0, 4095};
    const auto snapshot = decoded(decoder, message_of(message));
    EXPECT_EQ(snapshot->channel(0), Pulse::from_microseconds(1000));
    EXPECT_EQ(snapshot->channel(1), Pulse::from_microseconds(2000));
}

TEST(RcInputDecoder, HoldsOnToTheFirstNodeUntilThatIsGone) {
    RcDecoder decoder({});
    RcInput message;
    message.rcin = {1500};
    EXPECT_TRUE(decoded(decoder, message_of(message, 42, 0), kStart));
    EXPECT_FALSE(decoded(decoder, message_of(message, 43, 0), kStart + milliseconds(2999)));
    EXPECT_TRUE(decoded(decoder, message_of(message, 43, 1), kStart + milliseconds(3000)));
    EXPECT_FALSE(decoded(decoder, message_of(message, 42, 1), kStart + milliseconds(3001)));
}

TEST(RcInputDecoder, ListensOnlyToTheNodeThatWasChosen) {
    RcDecoder decoder({.source = {43}});
    RcInput message;
    message.rcin = {1500};
    EXPECT_FALSE(decoded(decoder, message_of(message, 42)));
    EXPECT_TRUE(decoded(decoder, message_of(message, 43)));
}

TEST(RcInputDecoder, ListensOnlyToTheReceiverThatWasChosen) {
    RcDecoder decoder({.receiver = 2});
    RcInput message;
    message.rcin = {1500};
    message.id = 1;
    EXPECT_FALSE(decoded(decoder, message_of(message, 42, 0)));
    message.id = 2;
    EXPECT_TRUE(decoded(decoder, message_of(message, 42, 1)));
}

TEST(RcInputDecoder, LeavesOutWhatItHasNoChannelFor) {
    RcInput message;
    for (int i = 0; i < 32; ++i) {
        message.rcin.push_back(1000);
    }
    for (const bool fd : {false, true}) {
        RcDecoder decoder({.fd = fd});
        const auto snapshot = decoded(decoder, message_of(message, 42, 0, fd));
        ASSERT_TRUE(snapshot) << fd;
        EXPECT_TRUE(snapshot->has_first(kChannelCount));
    }
}

TEST(RcInputDecoder, CountsADamagedMessage) {
    RcDecoder decoder({});
    auto damaged = kGood;
    damaged[2].data[0] ^= 1U;
    EXPECT_FALSE(decoded(decoder, damaged));
    EXPECT_EQ(count_named(decoder.rejected(), "crc"), 1U);
}

TEST(RcInputDecoder, CountsAMessageWhoseEndIsMissing) {
    RcDecoder decoder({});
    auto torn = kGood;
    torn.pop_back();
    EXPECT_FALSE(decoded(decoder, torn));
    EXPECT_TRUE(decoded(decoder, kFailsafe));
    EXPECT_EQ(count_named(decoder.rejected(), "incomplete"), 1U);
}

TEST(RcInputDecoder, CountsAMessageOfAnotherNode) {
    RcDecoder decoder({.source = {7}});
    EXPECT_FALSE(decoded(decoder, kGood));
    EXPECT_EQ(count_named(decoder.rejected(), "other source"), 5U);
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
}  // namespace tribus::dronecan::rc_test
