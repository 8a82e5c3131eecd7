#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/sbus_streams.h"
#include "tests/support/streams.h"
#include "transports/codecs/sbus/sbus.h"

namespace tribus::codec_sbus_test {
namespace {

using test::all_sticks;
using test::Bytes;
using test::feed;
using test::feed_into;
using test::FrameStream;
using test::Random;
using test::same_frames;
using test::SbusSticks;

/// Returns frames, SBUS2 frames, slots and noise in a stream with many faults.
Bytes mixed_stream(Random& random) {
    constexpr std::array<std::uint8_t, 8> kFooters{0x00, 0x00, 0x00, 0x04, 0x14, 0x24, 0x34, 0x08};
    Bytes bytes;
    while (bytes.size() < 3000) {
        const bool hard = random.below(2) == 0;
        const std::uint8_t footer = kFooters[random.below(kFooters.size())];
        for (std::uint32_t count = random.below(4); count > 0; --count) {
            test::append(bytes, test::sbus_frame(test::random_payload(random, hard),
                                                 random.byte() & 0x0FU, footer));
            for (std::uint32_t slot = footer == 0 ? 0 : random.below(9); slot > 0; --slot) {
                test::append(bytes,
                             test::slot_triple(random.below(32), random.byte(), random.byte()));
            }
        }
        for (std::uint32_t count = random.below(6); count > 0; --count) {
            bytes.push_back(hard ? 0x0F : random.byte());
        }
    }
    return bytes;
}

TEST(SbusStreamProperty, EveryFrameHasHeaderFlagsAndFooterAndNoTwoOverlap) {
    for (std::uint32_t seed = 1; seed <= 200; ++seed) {
        Random random(seed);
        const Bytes bytes = mixed_stream(random);
        SbusDecoder decoder;
        std::uint64_t free_from = 0;
        for (const DecodedFrame& frame : feed(decoder, bytes)) {
            const auto first = static_cast<std::size_t>(frame.first_byte);
            const auto wire = std::span(bytes).subspan(first, kSbusFrameLength);
            ASSERT_GE(frame.first_byte, free_from);
            ASSERT_EQ(wire[0], 0x0F);
            ASSERT_LT(wire[23], 0x10);
            ASSERT_TRUE(wire[24] % 4 == 0 && wire[24] % 16 != 12);
            free_from = frame.first_byte + kSbusFrameLength;
        }
        ASSERT_GT(free_from, 0U);
    }
}

TEST(SbusStreamProperty, DoesNotDependOnHowTheStreamIsCut) {
    for (std::uint32_t seed = 1; seed <= 60; ++seed) {
        Random random(seed);
        const Bytes bytes = mixed_stream(random);
        SbusDecoder whole;
        const auto expected = feed(whole, bytes);
        for (const test::Split split :
             {test::kByteByByte, test::Split{3, seed}, test::Split{100, seed}, test::Split{25}}) {
            SbusDecoder decoder;
            ASSERT_TRUE(same_frames(feed(decoder, bytes, split), expected)) << "seed " << seed;
            ASSERT_EQ(decoder.skipped_bytes(), whole.skipped_bytes());
            ASSERT_EQ(test::count_of(decoder, "framing"), test::count_of(whole, "framing"));
        }
    }
}

// Bytes that are neither in a frame nor skipped are slots: whole triples, at most eight after a
// frame.
TEST(SbusStreamProperty, EveryByteIsInAFrameOrASlotOrSkipped) {
    for (std::uint32_t seed = 1; seed <= 100; ++seed) {
        Random random(seed);
        Bytes bytes = mixed_stream(random);
        bytes.insert(bytes.end(), 200, 0xFF);  // ends whatever the decoder waits for
        SbusDecoder decoder;
        const std::size_t frames = feed(decoder, bytes).size();
        const std::uint64_t known = frames * kSbusFrameLength + decoder.skipped_bytes();
        ASSERT_LE(known, bytes.size()) << "seed " << seed;
        ASSERT_EQ((bytes.size() - known) % 3, 0U) << "seed " << seed;
        ASSERT_LE(bytes.size() - known, frames * 24) << "seed " << seed;
    }
}

TEST(SbusStreamProperty, AStreamWithoutFaultsHasNothingToSkip) {
    for (const SbusSticks& sticks : all_sticks(10)) {
        for (const std::uint32_t triples : {0U, 1U, 3U, 8U}) {
            const FrameStream stream = test::sbus2_stream(sticks, 0x03, 20, triples);
            SbusDecoder decoder;
            ASSERT_EQ(feed(decoder, stream.bytes).size(), 20U) << sticks.name;
            ASSERT_EQ(decoder.skipped_bytes(), 0U) << sticks.name;
        }
    }
}

TEST(SbusStreamProperty, DamagedBytesAnywhereNeverOverrunOrComeInAFrame) {
    for (std::uint32_t seed = 1; seed <= 200; ++seed) {
        Random random(seed);
        const Bytes bytes = mixed_stream(random);
        SCOPED_TRACE(seed);
        SbusDecoder decoder;
        test::expect_no_frame_over_damage(decoder, bytes, random, 150);
    }
}

TEST(SbusStreamProperty, SurvivesADamagedLine) {
    SbusDecoder decoder;
    std::span<const std::uint8_t> nothing;
    for (int count = 0; count < 1000; ++count) {
        decoder.damaged_byte();
        DecodedFrame frame;
        ASSERT_FALSE(decoder.next(nothing, {}, frame));
    }
    const FrameStream stream = test::sbus_stream(
        test::still("all 992", test::payload_of("e0 03 1f f8 c0 07 3e f0 81 0f 7c")), 0, 5);
    EXPECT_GE(feed(decoder, stream.bytes).size(), 4U);
}

/// Decodes two equal frames. The second proves the first.
std::optional<ChannelFrame> decoded(const SbusScale& scale, std::span<const std::uint8_t> wire) {
    SbusDecoder decoder(scale);
    feed(decoder, wire);
    const auto frame = decoder.finish();
    return frame ? std::optional(frame->channels) : std::nullopt;
}

Bytes encoded(const SbusScale& scale, const ChannelFrame& frame) {
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = SbusEncoder(scale).write(frame, wire, Instant{});
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}

/// Each channel takes all 2048 values, with different values in its neighbours.
void expect_bit_exact(const SbusScale& scale, unsigned flags) {
    for (unsigned base = 0; base <= kSbusRawMost; ++base) {
        SbusFrame frame;
        for (unsigned channel = 0; channel < kSbusChannels; ++channel) {
            frame.raw[channel] = static_cast<std::uint16_t>((base + 683 * channel) % 2048);
        }
        frame.channel_17 = (flags & 1U) != 0;
        frame.channel_18 = (flags & 2U) != 0;
        frame.frame_lost = (flags & 4U) != 0;
        frame.failsafe = (flags & 8U) != 0;
        Bytes wire(kSbusFrameLength);
        emit_sbus(frame, std::span(wire).first<kSbusFrameLength>());
        const auto channels = decoded(scale, wire);
        ASSERT_TRUE(channels);
        ASSERT_EQ(encoded(scale, *channels), wire) << "base " << base << ", flags " << flags;
    }
}

TEST(SbusRoundTrip, IsBitExactForAllValuesAndFlagsInEveryNamedScale) {
    for (const std::string_view name : {"betaflight", "ardupilot", "px4", "frsky", "futaba"}) {
        for (unsigned flags = 0; flags < 16; ++flags) {
            expect_bit_exact(*SbusScale::named(name), flags);
        }
    }
}

// The scale goes through any two points, as long as its pulses are allowed and neighbours are at
// least 0.25 us apart.
RC_GTEST_PROP(SbusRoundTripProperty, IsExactForAllValuesInAnyScale, ()) {
    const int raw_low = *rc::gen::inRange(0, 2047);
    const int raw_high = *rc::gen::inRange(raw_low + 1, 2048);
    const double steepness = *rc::gen::inRange(25, 190) / 100.0;
    const double sign = *rc::gen::element(1.0, -1.0);
    const double middle = *rc::gen::inRange(-1000, 1000);
    const double slope = sign * steepness;
    const SbusScale scale = SbusScale::through(
        {{static_cast<double>(raw_low), static_cast<double>(raw_high)},
         {middle + slope * (raw_low - 1023), middle + slope * (raw_high - 1023)}});
    for (int raw = 0; raw <= kSbusRawMost; ++raw) {
        RC_ASSERT(scale.encode(scale.decode(static_cast<std::uint16_t>(raw))) == raw);
    }
}

RC_GTEST_PROP(SbusEncoderProperty, EveryFrameHasAnEncodingThatDecodes, ()) {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (*rc::gen::inRange(0, 4) != 0) {
            frame.set(channel, Pulse::from_eighths(*rc::gen::inRange(-32768, 32768)));
        }
    }
    frame.frame_lost = *rc::gen::arbitrary<bool>();
    frame.failsafe = *rc::gen::arbitrary<bool>();
    const SbusScale scale = *SbusScale::named(*rc::gen::elementOf(
        std::vector<std::string>{"betaflight", "ardupilot", "px4", "frsky", "futaba"}));
    const auto channels = decoded(scale, encoded(scale, frame));
    RC_ASSERT(channels.has_value());
    RC_ASSERT(channels->frame_lost == frame.frame_lost);
    RC_ASSERT(channels->failsafe == frame.failsafe);
    for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
        const int sent = std::clamp(frame.channel_or(channel, kCentrePulse).eighths(),
                                    scale.decode(0).eighths(), scale.decode(2047).eighths());
        RC_ASSERT(std::abs(channels->channel(channel)->eighths() - sent) <= 4);
    }
}

}  // namespace
}  // namespace tribus::codec_sbus_test
