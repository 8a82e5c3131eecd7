#include "transports/codecs/mavlink/signature.h"

#include <chrono>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/channel_bytes.h"
#include "tests/support/fixed_clock.h"
#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/mavlink/mavlink_messages.h"
#include "transports/codecs/mavlink/mavlink.h"
#include "transports/codecs/mavlink/telemetry.h"

/// The vectors were computed with hashlib of Python: SHA-256 over key, frame, link id and time.
namespace tribus::test::mavlink_signature_test {
namespace {

using namespace std::chrono_literals;

/// 2026-11-26, 00:00:00 UTC.
constexpr Duration kDay = 1795651200s;
/// The same in time stamps.
constexpr std::uint64_t kDayStamp = 37558080000000;
constexpr Instant kStart{1000s};

/// kOverride, signed with the key 01 02 03 to 20 on link 7 at kDay.
constexpr std::string_view kSignedOverride =
    "fd22010000ffbe460000dc05dc05e803dc05e803e803d007dc0501014c04b00414057805dc054006a4060807"
    "0d3b 07 005004ac2822 a7a51c727d9c";
/// kHeartbeatOfAStation as message 1, 10 us later.
constexpr std::string_view kSignedHeartbeat =
    "fd09010001ffbe0000000000000006080004 03ca3e 07 015004ac2822 15375547266f";

SecretKey key() {
    SecretKey secret{};
    std::iota(secret.begin(), secret.end(), std::uint8_t{1});
    return secret;
}

/// A message with other channels for each `number`, signed by `signer`.
Bytes signed_override(MavlinkSigner& signer, Instant at, std::uint8_t system = 255,
                      std::uint16_t pulse = 1500) {
    const Bytes payload{static_cast<std::uint8_t>(pulse), static_cast<std::uint8_t>(pulse >> 8U)};
    Bytes frame = message_2(70, 124, payload, {.system = system, .component = 190, .flags = 1});
    signer.sign(frame, frame.size() - 13, at);
    return frame;
}

struct Receiver {
    explicit Receiver(const WallClock* clock = nullptr) {
        if (clock != nullptr) {
            decoder.use_clock(*clock);
        }
    }
    /// How many frames with channels the bytes are.
    std::size_t takes(const Bytes& bytes, Instant at = kStart) {
        return feed(decoder, bytes, kOneRead, at).size();
    }
    std::uint64_t refused(std::string_view cause) const { return count_of(decoder, cause); }
    MavlinkDecoder decoder{{.key = key()}};
};

TEST(MavlinkSignature, IsThatOfTheVectors) {
    const FixedClock clock(kDay, kStart);
    MavlinkEncoder encoder(
        {.message = MavlinkChannels::rc_channels_override, .key = key(), .link_id = 7});
    encoder.use_clock(clock);
    Bytes expected = from_hex(kSignedOverride);
    append(expected, from_hex(kSignedHeartbeat));
    EXPECT_EQ(encoded(encoder, frame_of_microseconds(kSixteenPulses), kStart), expected);
}

TEST(MavlinkSignature, InTheVectorsIsTaken) {
    const FixedClock clock(kDay + 59s, kStart);
    Receiver receiver(&clock);
    EXPECT_EQ(receiver.takes(from_hex(kSignedOverride)), 1U);
    EXPECT_EQ(receiver.takes(from_hex(kSignedHeartbeat)), 0U);
    for (const NamedCount& cause : receiver.decoder.rejected()) {
        EXPECT_EQ(cause.count, 0U) << cause.name;
    }
}

TEST(MavlinkSignature, IsNotLookedAtWithoutAKey) {
    MavlinkDecoder decoder({});
    EXPECT_EQ(feed(decoder, from_hex(kSignedOverride)).size(), 1U);
    EXPECT_EQ(feed(decoder, from_hex(kSignedOverride)).size(), 1U);
    EXPECT_EQ(decoder.rejected().size(), 3U);
}

TEST(MavlinkSignature, EveryFlippedBitIsRefused) {
    const Bytes good = from_hex(kSignedOverride);
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
        Bytes bytes = good;
        bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
        Receiver receiver;
        EXPECT_EQ(receiver.takes(bytes), 0U) << bit;
        // What comes behind is read again.
        std::size_t more = 0;
        MavlinkSigner signer(key(), 9);
        for (int i = 0; i < 8; ++i) {
            more += receiver.takes(signed_override(signer, kStart + kDay + i * 20ms));
        }
        EXPECT_GE(more, 2U) << bit;
    }
}

TEST(MavlinkSignature, WithARightCrcButOtherContentIsWrong) {
    MavlinkSigner signer(key(), 0);
    Bytes bytes = signed_override(signer, kStart);
    const Bytes other = signed_override(signer, kStart, 255, 1501);
    // The CRC and payload of another message, with the signature of this one.
    std::copy(other.begin(), other.end() - 13, bytes.begin());
    Receiver receiver;
    EXPECT_EQ(receiver.takes(bytes), 0U);
    EXPECT_EQ(receiver.refused("wrong_signature"), 1U);
}

TEST(MavlinkSignature, WithAnotherKeyIsWrong) {
    for (const std::size_t place : {0U, 15U, 31U}) {
        SecretKey other = key();
        other[place] ^= 0x80;
        MavlinkSigner signer(other, 0);
        Receiver receiver;
        EXPECT_EQ(receiver.takes(signed_override(signer, kStart)), 0U);
        EXPECT_EQ(receiver.refused("wrong_signature"), 1U);
    }
}

TEST(MavlinkSignature, IsNeededWithAKey) {
    Receiver receiver;
    EXPECT_EQ(receiver.takes(from_hex(kOverride)), 0U);
    EXPECT_EQ(receiver.takes(from_hex(kOverride1)), 0U);
    EXPECT_EQ(receiver.takes(from_hex(kRadioGood)), 0U);
    EXPECT_EQ(receiver.takes(from_hex(kRcChannelsOfAnAutopilot)), 0U);
    EXPECT_EQ(receiver.takes(from_hex(kManual)), 0U);
    EXPECT_EQ(receiver.refused("unsigned"), 5U);
}

/// SYS_STATUS without a signature must not end a failsafe that RC_CHANNELS tells by it.
TEST(MavlinkSignature, IsNeededForTheStateOfTheReceiverToo) {
    const auto status = [](bool healthy) {
        Bytes payload(31);
        payload[6] = 1;
        payload[10] = healthy ? 1 : 0;
        return payload;
    };
    MavlinkSigner signer(key(), 0);
    const auto signed_message = [&](std::uint32_t id, std::uint8_t extra, const Bytes& payload) {
        Bytes bytes = message_2(id, extra, payload, {.flags = 1});
        signer.sign(bytes, bytes.size() - 13, kStart);
        return bytes;
    };
    Receiver receiver;
    const Bytes rc = from_hex(kRcChannelsOfAnAutopilot);
    const Bytes channels(rc.begin() + 10, rc.end() - 2);
    EXPECT_EQ(receiver.takes(signed_message(1, 124, status(false))), 0U);
    EXPECT_EQ(receiver.takes(message_2(1, 124, status(true))), 0U);
    const auto frames = feed(receiver.decoder, signed_message(65, 118, channels));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_TRUE(frames[0].channels.failsafe);
}

TEST(MavlinkSignature, CountsOnce) {
    Receiver receiver;
    MavlinkSigner signer(key(), 3);
    const Bytes first = signed_override(signer, kStart);
    const Bytes second = signed_override(signer, kStart);
    EXPECT_EQ(receiver.takes(first), 1U);
    EXPECT_EQ(receiver.takes(second), 1U);
    EXPECT_EQ(receiver.takes(second), 0U);
    EXPECT_EQ(receiver.takes(first), 0U);
    EXPECT_EQ(receiver.refused("replayed"), 2U);
}

TEST(MavlinkSignature, CountsOnceAlsoAfterTheLineWasUnplugged) {
    Receiver receiver;
    MavlinkSigner signer(key(), 3);
    const Bytes first = signed_override(signer, kStart);
    EXPECT_EQ(receiver.takes(first), 1U);
    receiver.decoder.reset();
    EXPECT_EQ(receiver.takes(first), 0U);
    EXPECT_EQ(receiver.refused("replayed"), 1U);
}

TEST(MavlinkSignature, BelongsToAStreamOfSystemComponentAndLink) {
    Receiver receiver;
    MavlinkSigner ahead(key(), 0);
    MavlinkSigner behind(key(), 1);
    EXPECT_EQ(receiver.takes(signed_override(ahead, kStart + 50s)), 1U);
    // Each stream has times of its own.
    EXPECT_EQ(receiver.takes(signed_override(behind, kStart)), 1U);
    EXPECT_EQ(receiver.takes(signed_override(behind, kStart)), 1U);
    EXPECT_EQ(receiver.refused("replayed"), 0U);
}

TEST(MavlinkSignature, BeginsAStreamWithinAMinuteOfTheClock) {
    for (const auto& [age, taken] : {std::pair{60s, true}, std::pair{61s, false}}) {
        const FixedClock clock(kDay, kStart);
        const FixedClock of_sender(kDay - age, kStart);
        Receiver receiver(&clock);
        MavlinkSigner signer(key(), 0);
        signer.use_clock(of_sender);
        EXPECT_EQ(receiver.takes(signed_override(signer, kStart)), taken ? 1U : 0U);
        EXPECT_EQ(receiver.refused("too_old"), taken ? 0U : 1U);
    }
}

TEST(MavlinkSignature, BeginsAStreamWithinAMinuteOfTheNewestMessage) {
    for (const auto& [age, taken] : {std::pair{60s, true}, std::pair{61s, false}}) {
        Receiver receiver;
        MavlinkSigner newest(key(), 0);
        MavlinkSigner signer(key(), 1);
        EXPECT_EQ(receiver.takes(signed_override(newest, kStart)), 1U);
        EXPECT_EQ(receiver.takes(signed_override(signer, kStart - age)), taken ? 1U : 0U);
        EXPECT_EQ(receiver.refused("too_old"), taken ? 0U : 1U);
    }
}

TEST(MavlinkSignature, BeginsOnlyAsManyStreamsAsAreKept) {
    Receiver receiver;
    for (std::size_t link = 0; link <= MavlinkVerifier::kMostStreams; ++link) {
        MavlinkSigner signer(key(), static_cast<std::uint8_t>(link));
        const bool room = link < MavlinkVerifier::kMostStreams;
        EXPECT_EQ(receiver.takes(signed_override(signer, kStart)), room ? 1U : 0U) << link;
    }
    EXPECT_EQ(receiver.refused("too_many_streams"), 1U);
    // A stranger without the key takes no room.
    MavlinkSigner first(key(), 0);
    EXPECT_EQ(receiver.takes(signed_override(first, kStart + 1s)), 1U);
}

// A decoder of its own is a program that has started again: nothing is kept on a disk.

TEST(MavlinkSignature, FromTheMinuteBeforeARestartCountsOnceMoreInItsOrder) {
    const FixedClock clock(kDay, kStart);
    MavlinkSigner sender(key(), 0);
    sender.use_clock(clock);
    const Bytes old = signed_override(sender, kStart - 61s);
    const Bytes first = signed_override(sender, kStart - 50s);
    const Bytes second = signed_override(sender, kStart - 40s);
    Receiver before(&clock);
    EXPECT_EQ(before.takes(first) + before.takes(second), 2U);
    EXPECT_EQ(before.takes(first) + before.takes(second), 0U);
    Receiver after(&clock);
    EXPECT_EQ(after.takes(old), 0U);
    EXPECT_EQ(after.refused("too_old"), 1U);
    EXPECT_EQ(after.takes(first) + after.takes(second), 2U);
    EXPECT_EQ(after.takes(first) + after.takes(second), 0U);
}

TEST(MavlinkSignature, FromBeforeARestartCountsNoMoreOnceTheSenderWasHeard) {
    const FixedClock clock(kDay, kStart);
    MavlinkSigner sender(key(), 0);
    sender.use_clock(clock);
    const Bytes recorded = signed_override(sender, kStart - 10s);
    Receiver after(&clock);
    EXPECT_EQ(after.takes(signed_override(sender, kStart)), 1U);
    EXPECT_EQ(after.takes(recorded), 0U);
    EXPECT_EQ(after.refused("replayed"), 1U);
}

/// The time stamp of a message of `signer`.
std::uint64_t stamp_of(MavlinkSigner& signer, Instant at) {
    const Bytes bytes = signed_override(signer, at);
    std::uint64_t stamp = 0;
    for (std::size_t byte = 0; byte < 6; ++byte) {
        stamp |= std::uint64_t{bytes.at(bytes.size() - 12 + byte)} << (8 * byte);
    }
    return stamp;
}

TEST(MavlinkSigner, CountsTensOfMicrosecondsSince2015) {
    const FixedClock clock(kDay, kStart);
    MavlinkSigner signer(key(), 0);
    signer.use_clock(clock);
    EXPECT_EQ(stamp_of(signer, kStart), kDayStamp);
    EXPECT_EQ(stamp_of(signer, kStart + 1s), kDayStamp + 100000);
}

TEST(MavlinkSigner, NeverUsesATimeTwiceAndNeverGoesBack) {
    FixedClock clock(kDay, kStart);
    MavlinkSigner signer(key(), 0);
    signer.use_clock(clock);
    EXPECT_EQ(stamp_of(signer, kStart), kDayStamp);
    EXPECT_EQ(stamp_of(signer, kStart), kDayStamp + 1);
    clock.set(kDay - 1h, kStart);
    EXPECT_EQ(stamp_of(signer, kStart + 1s), kDayStamp + 2);
    // As soon as the clock is right, the time is.
    clock.set(kDay + 1h, kStart + 2s);
    EXPECT_EQ(stamp_of(signer, kStart + 2s), kDayStamp + 360000000);
}

TEST(MavlinkSigner, BeginsAtOneWhereTheClockIsBefore2015) {
    const FixedClock clock(0s, kStart);
    MavlinkSigner signer(key(), 0);
    signer.use_clock(clock);
    EXPECT_EQ(stamp_of(signer, kStart), 1U);
    EXPECT_EQ(stamp_of(signer, kStart + 1s), 2U);
}

TEST(MavlinkSigner, GoesOnOverAReload) {
    const MavlinkEncoder::Settings settings{.message = MavlinkChannels::rc_channels_override,
                                            .key = key()};
    const FixedClock clock(kDay, kStart);
    const FixedClock set_back(kDay - 1h, kStart);
    MavlinkEncoder before(settings);
    before.use_clock(clock);
    MavlinkEncoder after(settings);
    after.use_clock(set_back);
    Receiver receiver;
    const ChannelFrame frame = frame_of_microseconds(kSixteenPulses);
    EXPECT_EQ(receiver.takes(encoded(before, frame, kStart)), 1U);
    after.continue_from(before);
    EXPECT_EQ(receiver.takes(encoded(after, frame, kStart + 20ms)), 1U);
}

TEST(MavlinkSigner, SignsEveryMessageThatAnOutputSends) {
    ChannelFrame frame = frame_of_microseconds(std::vector<double>(18, 2000));
    frame.received = Instant{} + 800h;
    frame.failsafe = true;
    for (const auto message :
         {MavlinkChannels::radio_rc_channels, MavlinkChannels::rc_channels_override,
          MavlinkChannels::manual_control}) {
        const bool releases = message == MavlinkChannels::rc_channels_override;
        MavlinkEncoder encoder({.message = message,
                                .channels = 18,
                                .buttons = 14,
                                .releases = releases,
                                .key = key()});
        Receiver receiver;
        std::size_t frames = 0;
        for (int i = 0; i < 100; ++i) {
            const Bytes bytes = encoded(encoder, frame, kStart + i * 20ms);
            ASSERT_LE(bytes.size(), MavlinkEncoder::kLongestSigned);
            frames += receiver.takes(bytes);
        }
        EXPECT_EQ(frames, 100U);
        std::array<std::uint8_t, kLongestSerialFrame> wire{};
        const std::size_t length = encoder.write_silence(wire, kStart + 3s);
        EXPECT_EQ(receiver.takes({wire.begin(), wire.begin() + static_cast<long>(length)}),
                  releases ? 1U : 0U);
        for (const NamedCount& cause : receiver.decoder.rejected()) {
            EXPECT_EQ(cause.count, 0U) << cause.name;
        }
    }
    MavlinkEncoder longest({.channels = 18, .key = key()});
    EXPECT_EQ(encoded(longest, frame).size(), MavlinkEncoder::kLongestSigned);
}

/// How many messages with values the bytes are.
std::size_t values_in(MavlinkTelemetryReader& reader, const Bytes& bytes) {
    std::vector<ValueReading> readings(reader.values().size());
    std::span<const std::uint8_t> rest(bytes);
    std::size_t messages = 0;
    while (reader.next(rest, kStart, readings)) {
        ++messages;
    }
    return messages;
}

TEST(MavlinkTelemetry, WithAKeyTakesOnlyWhatIsSignedAndTheRadiosOwnWord) {
    MavlinkTelemetryReader reader(key());
    const Bytes attitude(28, 1);
    EXPECT_EQ(values_in(reader, message_2(30, 39, attitude)), 0U);
    MavlinkSigner signer(key(), 0);
    Bytes bytes = message_2(30, 39, attitude, {.flags = 1});
    signer.sign(bytes, bytes.size() - 13, kStart);
    EXPECT_EQ(values_in(reader, bytes), 1U);
    EXPECT_EQ(values_in(reader, bytes), 0U);
    EXPECT_EQ(values_in(reader, message_2(109, 185, Bytes(9, 1), {.system = 51})), 1U);
    // A signature that is there must be right.
    EXPECT_EQ(values_in(reader, message_2(109, 185, Bytes(9, 1), {.system = 51, .flags = 1})), 0U);
}

}  // namespace
}  // namespace tribus::test::mavlink_signature_test
