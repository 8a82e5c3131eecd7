#include "tests/support/stream_rules.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::test {
namespace {

/// At least: a read of all, and reads of one byte each.
constexpr Split kSplits[] = {kOneRead, kByteByByte, {.longest = 9, .seed = 3}};

std::vector<std::size_t> places_of(std::span<const DecodedFrame> frames) {
    std::vector<std::size_t> places;
    for (const DecodedFrame& frame : frames) {
        places.push_back(static_cast<std::size_t>(frame.first_byte));
    }
    return places;
}

/// Only the frame behind the first `length` bytes is found.
void expect_only_the_frame_behind(std::size_t length, const MakeDecoder& make, const Bytes& bytes) {
    for (const Split split : kSplits) {
        const auto decoder = make();
        ASSERT_EQ(places_of(all_frames(*decoder, bytes, split)), std::vector{length});
    }
}

}  // namespace

void expect_each_flipped_bit_is_refused(const MakeDecoder& make,
                                        std::span<const std::uint8_t> frame,
                                        std::span<const std::uint8_t> next) {
    for (std::size_t bit = 0; bit < 8 * frame.size(); ++bit) {
        SCOPED_TRACE(testing::Message() << "bit " << bit);
        Bytes bytes(frame.begin(), frame.end());
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
        append(bytes, next);
        expect_only_the_frame_behind(frame.size(), make, bytes);
    }
}

void expect_a_frame_behind_every_cut_one(const MakeDecoder& make,
                                         std::span<const std::uint8_t> frame,
                                         std::span<const std::uint8_t> next) {
    for (std::size_t cut = 1; cut < frame.size(); ++cut) {
        SCOPED_TRACE(testing::Message() << cut << " bytes");
        Bytes bytes;
        append(bytes, frame.first(cut));
        append(bytes, next);
        expect_only_the_frame_behind(cut, make, bytes);
    }
}

void expect_a_pause_ends_a_frame(const MakeDecoder& make, std::span<const std::uint8_t> frame,
                                 std::span<const std::uint8_t> next) {
    for (std::size_t cut = 1; cut < frame.size(); ++cut) {
        const auto decoder = make();
        EXPECT_TRUE(all_frames(*decoder, frame.first(cut)).empty()) << cut;
        EXPECT_EQ(decoder->waiting(), 0U) << cut;
        EXPECT_TRUE(all_frames(*decoder, frame.subspan(cut)).empty()) << cut;
        EXPECT_EQ(all_frames(*decoder, next).size(), 1U) << cut;
    }
}

void expect_the_same_however_cut(const MakeDecoder& make, std::span<const std::uint8_t> bytes,
                                 std::size_t count) {
    const auto whole = make();
    const auto expected = feed(*whole, bytes);
    EXPECT_EQ(expected.size(), count);
    for (std::size_t cut = 0; cut <= std::min<std::size_t>(bytes.size(), 300); ++cut) {
        const auto decoder = make();
        auto frames = feed(*decoder, bytes.first(cut));
        feed_into(frames, *decoder, bytes.subspan(cut));
        EXPECT_TRUE(same_frames(frames, expected)) << cut;
        EXPECT_EQ(decoder->skipped_bytes(), whole->skipped_bytes()) << cut;
    }
    for (std::uint32_t longest = 1; longest < 60; ++longest) {
        for (const std::uint32_t seed : {0U, longest}) {
            const auto decoder = make();
            EXPECT_TRUE(
                same_frames(feed(*decoder, bytes, {.longest = longest, .seed = seed}), expected))
                << longest << ", seed " << seed;
            EXPECT_EQ(decoder->skipped_bytes(), whole->skipped_bytes());
        }
    }
}

void for_each_fault(const FrameStream& stream, std::span<const std::uint8_t> values,
                    const std::function<void(const Fault&, Split)>& check) {
    for (std::size_t position = 0; position < stream.bytes.size(); ++position) {
        for (const Split split : kSplits) {
            check({FaultKind::lost, position}, split);
            check({FaultKind::damaged, position}, split);
            for (const std::uint8_t value : values) {
                check({FaultKind::added, position, value}, split);
                check({FaultKind::replaced, position, value}, split);
            }
        }
    }
}

void expect_every_frame_behind_a_fault(const MakeDecoder& make, const FrameStream& stream,
                                       std::span<const std::uint8_t> values) {
    for_each_fault(stream, values, [&](const Fault& fault, Split split) {
        const auto decoder = make();
        const auto places = places_of(all_frames(*decoder, stream.bytes, split, fault));
        for (std::size_t i = 0; i < stream.starts.size(); ++i) {
            if (stream.starts[i] > fault.position) {
                EXPECT_EQ(std::ranges::count(places, stream.shifted_start(i, fault)), 1)
                    << fault << ", frame " << i;
            }
        }
    });
}

}  // namespace tribus::test
