#include <gtest/gtest.h>

#include <string_view>
#include <vector>

#include "tests/support/sbus_streams.h"
#include "tests/support/streams.h"
#include "transports/codecs/sbus/sbus.h"

/// What an SBUS decoder learns from a pause on the line.
namespace tribus::sbus_pauses_test {
namespace {

using test::Bytes;
using test::count_of;
using test::feed;
using test::from_hex;

// 100, 200 ... 1600; docs/protocols/sbus.md, "Vectors".
constexpr std::string_view kHundreds =
    "0f 64 40 06 4b 20 43 1f 2c f1 0a 64 84 43 1f 13 61 49 51 bc 72 17 c8 00 00";
// Bytes that a Futaba R7003SB sends 2 ms after each frame; bolderflight/sbus, issue 79.
constexpr std::string_view kTrailer = "00 03 c0 33 00";

/// Returns the frames of pieces with a pause before each piece except the first.
std::vector<DecodedFrame> with_pauses(SbusDecoder& decoder, const std::vector<Bytes>& pieces) {
    std::vector<DecodedFrame> frames;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        DecodedFrame frame;
        while (i != 0 && decoder.silence(frame)) {
            frames.push_back(frame);
        }
        test::feed_into(frames, decoder, pieces[i]);
    }
    return frames;
}

Bytes hundreds() {
    return from_hex(kHundreds);
}
Bytes first_of_hundreds(std::size_t count) {
    Bytes bytes = hundreds();
    bytes.resize(count);
    return bytes;
}

TEST(SbusPauses, AFrameBehindAPauseNeedsNoSecondOneAsProof) {
    SbusDecoder decoder;
    const auto frames = with_pauses(decoder, {from_hex("10 64 40"), hundreds(), {}});
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].first_byte, 3U);
}

TEST(SbusPauses, WhatStandsBetweenAFrameAndThePauseIsNoMatter) {
    for (const std::string_view behind : {"0f", "00", "ff", "0f 00 00", "03 c0", "03 c0 2e 00"}) {
        Bytes piece = hundreds();
        test::append(piece, from_hex(behind));
        SbusDecoder decoder;
        EXPECT_EQ(with_pauses(decoder, {hundreds(), piece, piece, piece}).size(), 4U) << behind;
        EXPECT_EQ(decoder.skipped_bytes(), 2 * from_hex(behind).size()) << behind;
    }
}

/// On a line that has shown no frame, the second burst of the same length does, from 24 channels it
/// would hardly come.
TEST(SbusPauses, StrayBytesBehindEachFrameCostTheFirstOne) {
    for (const std::string_view behind : {"0f", "00", "ff", "0f 00 00", "03 c0"}) {
        Bytes piece = hundreds();
        test::append(piece, from_hex(behind));
        SbusDecoder decoder;
        EXPECT_EQ(with_pauses(decoder, {{}, piece, piece, piece}).size(), 2U) << behind;
    }
}

TEST(SbusPauses, TheFramesOfAnR7003sbComeAll) {
    SbusDecoder decoder;
    std::vector<Bytes> pieces;
    for (int i = 0; i < 100; ++i) {
        pieces.push_back(hundreds());
        pieces.push_back(from_hex(kTrailer));
    }
    EXPECT_EQ(with_pauses(decoder, pieces).size(), 100U);
    EXPECT_EQ(count_of(decoder, "framing"), 0U) << "its trailer is no bad frame";
}

TEST(SbusPauses, FlagsAndFooterBehindAPauseDoNotEndAFrame) {
    // It begins with 0f e0: as flags and footer these are all four flags and an allowed footer.
    const Bytes all_992 =
        from_hex("0f e0 03 1f f8 c0 07 3e f0 81 0f 7c e0 03 1f f8 c0 07 3e f0 81 0f 7c 00 00");
    for (std::size_t cut = 1; cut < kSbusFrameLength; ++cut) {
        Bytes torn = all_992;
        torn.resize(cut);
        SbusDecoder decoder;
        const auto frames = with_pauses(decoder, {{}, all_992, torn, all_992, all_992});
        ASSERT_EQ(frames.size(), 3U) << cut;
        for (const DecodedFrame& frame : frames) {
            EXPECT_FALSE(frame.channels.failsafe) << cut;
        }
        EXPECT_EQ(count_of(decoder, "framing"), 1U) << cut;
        EXPECT_EQ(decoder.skipped_bytes(), cut);
    }
}

TEST(SbusPauses, AFrameThatLostAByteIsGoneWithThePauseAndTheNextOneComes) {
    for (std::size_t lost = 0; lost < kSbusFrameLength; ++lost) {
        Bytes torn = hundreds();
        torn.erase(torn.begin() + static_cast<std::ptrdiff_t>(lost));
        SbusDecoder decoder;
        EXPECT_EQ(with_pauses(decoder, {{}, hundreds(), torn, hundreds()}).size(), 2U) << lost;
    }
}

TEST(SbusPauses, TheFirstFrameOfAllIsProvedByThePauseBehindIt) {
    SbusDecoder decoder;
    EXPECT_TRUE(feed(decoder, hundreds()).empty());
    DecodedFrame frame;
    ASSERT_TRUE(decoder.silence(frame));
    EXPECT_EQ(frame.first_byte, 0U);
    EXPECT_FALSE(decoder.silence(frame));
}

TEST(SbusPauses, SoIsAFrameBehindNoiseThatBeganLikeNone) {
    for (const std::string_view noise : {"10", "00 0f", "ff 0f 00 00", "03 c0 2e"}) {
        Bytes piece = from_hex(noise);
        test::append(piece, hundreds());
        SbusDecoder decoder;
        EXPECT_EQ(with_pauses(decoder, {hundreds(), piece, {}}).size(), 2U) << noise;
    }
}

TEST(SbusPauses, ThePauseBehindAFrameProvesThatSlotsBegin) {
    Bytes with_slots = hundreds();
    with_slots.back() = 0x04;
    SbusDecoder decoder;
    EXPECT_EQ(with_pauses(decoder, {hundreds(), with_slots, {}}).size(), 2U);
    EXPECT_EQ(count_of(decoder, "framing"), 0U);
}

TEST(SbusPauses, APauseBehindMoreThanAFrameDoesNotProveThatSlotsBegin) {
    for (const std::string_view more : {"04 00", "0f 64", "0f 64 40 06"}) {
        Bytes with_more = hundreds();
        with_more.back() = 0x04;
        test::append(with_more, from_hex(more));
        SbusDecoder decoder;
        EXPECT_EQ(with_pauses(decoder, {hundreds(), with_more, {}}).size(), 1U) << more;
        EXPECT_EQ(count_of(decoder, "framing"), 1U) << more;
    }
}

TEST(SbusPauses, ABadFrameDoesNotEndWithAnotherOne) {
    // One byte was added, so the last 25 bytes look like a frame with all channels in wrong places.
    const Bytes bad =
        from_hex("0f 0f 40 06 4b 20 43 1f 2c f1 0a 64 84 43 1f 13 61 49 51 bc 72 17 c8 ff 00 00");
    SbusDecoder decoder;
    EXPECT_TRUE(with_pauses(decoder, {{}, bad, {}}).empty());
}

TEST(SbusPauses, WithoutAPauseASecondFrameIsTheProofAsEver) {
    SbusDecoder decoder;
    EXPECT_TRUE(feed(decoder, hundreds()).empty());
    EXPECT_EQ(feed(decoder, hundreds()).size(), 2U);
}

TEST(SbusPauses, BehindAResetNothingOfBeforeCompletesAFrame) {
    for (std::size_t cut = 0; cut < kSbusFrameLength; ++cut) {
        for (std::size_t from = 0; from < kSbusFrameLength; ++from) {
            SbusDecoder decoder;
            with_pauses(decoder, {{}, hundreds(), first_of_hundreds(cut)});
            decoder.reset();
            const Bytes rest = hundreds();
            const auto frames =
                feed(decoder, std::span(rest).subspan(from == 0 ? kSbusFrameLength : from));
            ASSERT_TRUE(frames.empty()) << cut << " bytes, then from " << from;
            ASSERT_EQ(with_pauses(decoder, {{}, hundreds(), {}}).size(), 1U);
        }
    }
}

TEST(SbusPauses, BehindAResetAFrameNeedsItsProofAnew) {
    SbusDecoder decoder;
    ASSERT_EQ(with_pauses(decoder, {{}, hundreds(), {}}).size(), 1U);
    decoder.reset();
    EXPECT_TRUE(feed(decoder, hundreds()).empty());
    EXPECT_FALSE(feed(decoder, hundreds()).empty()) << "the second one proves the first";
}

}  // namespace
}  // namespace tribus::sbus_pauses_test
