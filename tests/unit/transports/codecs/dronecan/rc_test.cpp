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

}  // namespace
}  // namespace tribus::dronecan::rc_test
