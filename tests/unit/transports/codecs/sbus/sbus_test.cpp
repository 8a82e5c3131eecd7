#include "transports/codecs/sbus/sbus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/sbus_frames.h"
#include "tests/support/sbus_streams.h"
#include "tests/support/streams.h"

namespace tribus::sbus_test {
namespace {

using namespace test;

Bytes repeated(std::string_view hex, int times) {
    Bytes bytes;
    for (int time = 0; time < times; ++time) {
        append(bytes, from_hex(hex));
    }
    return bytes;
}

TEST(SbusDecoder, ReadsAFramesChannelsInEighths) {
    SbusDecoder decoder;
    const auto frames = feed(decoder, repeated(kHundreds, 2));
    ASSERT_EQ(frames.size(), 2U);
    for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
        EXPECT_EQ(frames[0].channels.channel(channel),
                  Pulse::from_eighths(880 * 8 + 5 * 100 * static_cast<int>(channel + 1)));
    }
    EXPECT_EQ(frames[0].channels.channel(16), kSwitchOffPulse);
    EXPECT_EQ(frames[0].channels.channel(17), kSwitchOffPulse);
    EXPECT_EQ(frames[0].length, kSbusFrameLength);
}

TEST(SbusDecoder, ReadsArduPilotsVectorAsArduPilotDoes) {
    SbusDecoder decoder(*SbusScale::named("ardupilot"));
    const auto frames = feed(decoder, repeated(kUnusedZero, 2));
    ASSERT_EQ(frames.size(), 2U);
    const std::array expected{1562, 1496, 1000, 1531, 1806, 2006, 1495, 1495};
    for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
        EXPECT_EQ(frames[0].channels.channel(channel)->whole_microseconds(),
                  channel < expected.size() ? expected[channel] : 875);
    }
}

TEST(SbusDecoder, KeepsFrameLostFailsafeAndBothSwitchesApart) {
    for (unsigned flags = 0; flags < 16; ++flags) {
        Bytes bytes;
        for (int time = 0; time < 2; ++time) {
            Bytes frame = from_hex(kAll1024);
            frame[23] = static_cast<std::uint8_t>(flags);
            append(bytes, frame);
        }
        SbusDecoder decoder;
        const auto frames = feed(decoder, bytes);
        ASSERT_EQ(frames.size(), 2U) << flags;
        const ChannelFrame& channels = frames[0].channels;
        EXPECT_EQ(channels.channel(16), (flags & 1U) != 0 ? kSwitchOnPulse : kSwitchOffPulse);
        EXPECT_EQ(channels.channel(17), (flags & 2U) != 0 ? kSwitchOnPulse : kSwitchOffPulse);
        EXPECT_EQ(channels.frame_lost, (flags & 4U) != 0);
        EXPECT_EQ(channels.failsafe, (flags & 8U) != 0);
    }
}

TEST(SbusDecoder, ShowsRawValuesAndFooterOfTheLatestFrame) {
    SbusDecoder decoder;
    feed(decoder, repeated(kFasstest12, 2));
    const auto details = decoder.details();
    ASSERT_EQ(details.size(), 2U);
    EXPECT_EQ(details[0].name, "raw");
    EXPECT_TRUE(details[0].list);
    EXPECT_EQ(RawValues(details[0].values.begin(), details[0].values.end()),
              raw_values(parse(kFasstest12)));
    EXPECT_EQ(details[1].name, "footer");
    EXPECT_FALSE(details[1].list);
    EXPECT_EQ(details[1].values[0], 0x08);
}

/// Returns the frames after byte `position` of the third of five frames was set to `value`.
std::vector<DecodedFrame> with_byte_in_the_middle(SbusDecoder& decoder, std::size_t position,
                                                  unsigned value) {
    Bytes bytes = repeated(kAll1024, 5);
    bytes[2 * kSbusFrameLength + position] = static_cast<std::uint8_t>(value);
    return feed(decoder, bytes);
}

TEST(SbusDecoder, JudgesEveryFlagByteByItsHighNibble) {
    for (unsigned flags = 0; flags < 256; ++flags) {
        SbusDecoder decoder;
        const auto frames = with_byte_in_the_middle(decoder, 23, flags);
        const bool allowed = flags < 16;
        ASSERT_EQ(frames.size(), allowed ? 5U : 4U) << flags;
        EXPECT_EQ(count_of(decoder, "framing"), allowed ? 0U : 1U) << flags;
        EXPECT_EQ(decoder.skipped_bytes(), allowed ? 0U : 25U) << flags;
    }
}

TEST(SbusDecoder, JudgesEveryFooterByItsLowNibble) {
    for (unsigned footer = 0; footer < 256; ++footer) {
        SbusDecoder decoder;
        const auto frames = with_byte_in_the_middle(decoder, 24, footer);
        const unsigned low = footer % 16;
        const bool allowed = low == 0 || low == 4 || low == 8;
        ASSERT_EQ(frames.size(), allowed ? 5U : 4U) << footer;
        EXPECT_EQ(count_of(decoder, "framing"), allowed ? 0U : 1U) << footer;
    }
}

TEST(SbusDecoder, JudgesEveryHeader) {
    for (unsigned header = 0; header < 256; ++header) {
        SbusDecoder decoder;
        ASSERT_EQ(with_byte_in_the_middle(decoder, 0, header).size(), header == 0x0F ? 5U : 4U)
            << header;
    }
}

TEST(SbusDecoder, WantsASecondFrameBehindTheFirst) {
    SbusDecoder decoder;
    const Bytes bytes = repeated(kAll992, 3);
    const auto all = std::span<const std::uint8_t>(bytes);
    EXPECT_TRUE(feed(decoder, all.first(49)).empty());
    EXPECT_EQ(feed(decoder, all.subspan(49, 1)).size(), 2U);
}

TEST(SbusDecoder, AHeaderBehindTheFirstFrameIsNoProofOfIt) {
    for (const std::size_t spoilt : {23U, 24U}) {
        Bytes bytes = repeated(kAll1024, 2);
        bytes[kSbusFrameLength + spoilt] = 0xFF;
        append(bytes, repeated(kAll1024, 2));
        SbusDecoder decoder;
        const auto frames = feed(decoder, bytes);
        ASSERT_EQ(frames.size(), 2U);
        EXPECT_EQ(frames[0].first_byte, 2 * kSbusFrameLength);
    }
}

TEST(SbusDecoder, TakesAFrameWithItsLastByteOnceItIsLocked) {
    SbusDecoder decoder;
    const Bytes bytes = repeated(kAll992, 3);
    const auto all = std::span<const std::uint8_t>(bytes);
    feed(decoder, all.first(50));
    EXPECT_TRUE(feed(decoder, all.subspan(50, 24)).empty());
    const auto frames = feed(decoder, all.last(1), {}, Instant(std::chrono::milliseconds(9)));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].channels.received, Instant(std::chrono::milliseconds(9)));
}

TEST(SbusDecoder, StartsInTheMiddleOfAFrame) {
    const Bytes bytes = repeated(kHundreds, 4);
    for (std::size_t start = 1; start < kSbusFrameLength; ++start) {
        SbusDecoder decoder;
        const auto frames = feed(decoder, std::span(bytes).subspan(start));
        ASSERT_EQ(frames.size(), 3U) << "from byte " << start;
        EXPECT_EQ(frames[0].first_byte, kSbusFrameLength - start);
        EXPECT_EQ(decoder.skipped_bytes(), kSbusFrameLength - start);
        EXPECT_EQ(count_of(decoder, "framing"), 0U);
    }
}

TEST(SbusDecoder, FinishGivesALoneFrame) {
    for (const std::string_view hex : {kAll992, kFasstest14, kFasstest12, kFrsky, kUnusedZero}) {
        SbusDecoder decoder;
        EXPECT_TRUE(feed(decoder, from_hex(hex)).empty());
        const auto frame = decoder.finish();
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->first_byte, 0U);
        EXPECT_FALSE(decoder.finish());
    }
}

TEST(SbusDecoder, FinishGivesALoneFrameAmongItsNeighboursPieces) {
    Bytes bytes = from_hex(kHundreds);
    bytes.erase(bytes.begin(), bytes.begin() + 20);
    append(bytes, from_hex(kHundreds));
    append(bytes, from_hex(kHundreds.substr(0, 3 * 20)));
    SbusDecoder decoder;
    EXPECT_TRUE(feed(decoder, bytes).empty());
    const auto frame = decoder.finish();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->first_byte, 5U);
}

TEST(SbusDecoder, FinishGivesTheLastFrameBehindABadOne) {
    for (const auto& sticks : test::hard_sticks_that_stand_still()) {
        const auto stream = test::sbus_stream(sticks, 0, 4);
        for (std::size_t offset = 0; offset < kSbusFrameLength; ++offset) {
            SbusDecoder decoder;
            const test::Fault fault{test::FaultKind::lost, stream.starts[2] + offset, 0};
            auto frames = feed(decoder, stream.bytes, fault, test::kOneRead);
            ASSERT_EQ(frames.size(), 2U) << sticks.name << ", " << fault;
            const auto last = decoder.finish();
            ASSERT_TRUE(last) << sticks.name << ", " << fault;
            EXPECT_EQ(last->first_byte, stream.starts[3] - 1) << sticks.name << ", " << fault;
        }
    }
}

TEST(SbusDecoder, FinishGivesNothingWhenNothingIsWaiting) {
    SbusDecoder decoder;
    EXPECT_FALSE(decoder.finish());
    feed(decoder, repeated(kAll992, 3));
    EXPECT_FALSE(decoder.finish());
    feed(decoder, from_hex(kAll992.substr(0, 3 * 24)));
    EXPECT_FALSE(decoder.finish());
}

// docs/protocols/sbus.md, "Footer and SBUS2": one slot as a receiver sends it, or as many as
// sensors answer.
TEST(SbusDecoder, LosesNoFrameToTheSlotsOfSbus2) {
    for (const unsigned footer : {0x04U, 0x14U, 0x24U, 0x34U, 0x08U}) {
        for (std::uint32_t first_slot = 0; first_slot < 32; ++first_slot) {
            for (std::uint32_t triples = 0; triples <= 8; ++triples) {
                Bytes bytes;
                Bytes frame = from_hex(kFasstest14);
                frame[24] = static_cast<std::uint8_t>(footer);
                for (int time = 0; time < 4; ++time) {
                    append(bytes, frame);
                    for (std::uint32_t slot = 0; slot < triples; ++slot) {
                        append(bytes, slot_triple((first_slot + slot) % 32, 0xC0, 0x0F));
                    }
                }
                SbusDecoder decoder;
                ASSERT_EQ(feed(decoder, bytes).size(), 4U)
                    << "footer " << footer << ", " << triples << " slots from " << first_slot;
                ASSERT_EQ(decoder.skipped_bytes(), 0U);
                ASSERT_EQ(count_of(decoder, "framing"), 0U);
            }
        }
    }
}

TEST(SbusDecoder, SlotsMayHoldAnyBytes) {
    for (unsigned first = 0; first < 256; ++first) {
        for (unsigned second = 0; second < 256; second += 5) {
            Bytes bytes;
            for (int time = 0; time < 3; ++time) {
                append(bytes, from_hex(kFasstest14));
                append(bytes, slot_triple(0, static_cast<std::uint8_t>(first),
                                          static_cast<std::uint8_t>(second)));
            }
            SbusDecoder decoder;
            ASSERT_EQ(feed(decoder, bytes).size(), 3U) << first << " " << second;
        }
    }
}

TEST(SbusDecoder, KnowsNoSlotsBehindPlainSbus) {
    Bytes bytes = repeated(kAll1024, 3);
    append(bytes, slot_triple(0, 0xC0, 0x2E));
    append(bytes, repeated(kAll1024, 3));
    SbusDecoder decoder;
    feed(decoder, bytes);
    EXPECT_EQ(count_of(decoder, "framing"), 1U);
}

/// Two added bytes move its last payload bytes to the place of flags, without frame lost, and of a
/// footer that announces slots.
Bytes frame_lost_with_flags_and_footer_in_its_payload() {
    SbusPayload payload = payload_of("e0 03 1f f8 c0 07 3e f0 81 0f 7c");
    payload[20] = 0x03;
    payload[21] = 0x28;
    return sbus_frame(payload, 0x04, 0x00);
}

TEST(SbusDecoder, TwoBytesTooManyMakeNoFrameWithSlotsOfOneWithout) {
    const Bytes frame = frame_lost_with_flags_and_footer_in_its_payload();
    for (std::ptrdiff_t place = 1; place < 20; ++place) {
        Bytes longer = frame;
        longer.insert(longer.begin() + place, {0x00, 0x55});
        Bytes bytes;
        for (const Bytes& next : {frame, frame, longer, frame, longer, frame, frame}) {
            append(bytes, next);
        }
        SbusDecoder decoder;
        for (const DecodedFrame& decoded : feed(decoder, bytes)) {
            ASSERT_TRUE(decoded.channels.frame_lost) << place;
        }
    }
}

TEST(SbusDecoder, TakesSlotsThatBeginLater) {
    Bytes bytes = repeated(kAll1024, 3);
    for (int time = 0; time < 3; ++time) {
        append(bytes, from_hex(kFasstest14));
        append(bytes, slot_triple(0, 0xC0, 0x2E));
    }
    SbusDecoder decoder;
    EXPECT_EQ(feed(decoder, bytes).size(), 6U);
    EXPECT_EQ(decoder.skipped_bytes(), 0U);
    EXPECT_EQ(count_of(decoder, "framing"), 0U);
}

TEST(SbusDecoder, CountsADamagedByteAndNothingElse) {
    SbusDecoder decoder;
    const test::Fault fault{test::FaultKind::damaged, 2 * kSbusFrameLength + 7, 0};
    EXPECT_EQ(feed(decoder, repeated(kAll992, 5), fault, test::kOneRead).size(), 4U);
    EXPECT_EQ(count_of(decoder, "damaged"), 1U);
    EXPECT_EQ(count_of(decoder, "framing"), 0U);
    EXPECT_EQ(decoder.skipped_bytes(), kSbusFrameLength);
}

}  // namespace
}  // namespace tribus::sbus_test
