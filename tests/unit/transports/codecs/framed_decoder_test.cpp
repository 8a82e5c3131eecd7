#include "transports/codecs/framed_decoder.h"

#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

#include "tests/support/stream_rules.h"
#include "tests/support/streams.h"

namespace tribus::test::framed_decoder_test {
namespace {

/// A frame of this test: 5A, the number of payload bytes, the payload, the sum of all before. If
/// the payload is empty, it says nothing of channels.
class TinyDecoder final : public FramedDecoder {
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const override {
        if (bytes[0] != 0x5A) {
            return 0;
        }
        return bytes.size() < 2 ? 2 : std::size_t{3} + bytes[1] % 90U;
    }
    bool check_holds(std::span<const std::uint8_t> frame) const override {
        const auto body = frame.first(frame.size() - 1);
        return frame.back() ==
               static_cast<std::uint8_t>(std::accumulate(body.begin(), body.end(), 0U));
    }
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override {
        channels.set(0, Pulse::from_microseconds(frame[2]));
        return frame.size() > 3;
    }
};

Bytes tiny_frame(const Bytes& payload) {
    Bytes frame{0x5A, static_cast<std::uint8_t>(payload.size())};
    append(frame, payload);
    frame.push_back(static_cast<std::uint8_t>(std::accumulate(frame.begin(), frame.end(), 0U)));
    return frame;
}

const Bytes kFrame = tiny_frame({7, 0x5A, 9});

/// Frames whose payloads are full of first bytes of frames.
FrameStream frames_full_of_beginnings(std::uint32_t seed, std::size_t count) {
    Random random(seed);
    FrameStream stream;
    for (std::size_t i = 0; i < count; ++i) {
        Bytes payload(1 + random.below(20));
        std::ranges::generate(
            payload, [&] { return random.below(3) == 0 ? std::uint8_t{0x5A} : random.byte(); });
        stream.add_frame(tiny_frame(payload));
    }
    return stream;
}

TEST(FramedDecoder, FindsFramesBetweenOtherBytes) {
    TinyDecoder decoder;
    Bytes bytes{1, 2, 3};
    append(bytes, kFrame);
    bytes.push_back(4);
    append(bytes, kFrame);
    const auto frames = feed(decoder, bytes, kOneRead, Instant(Duration(5)));
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_EQ(frames[0].first_byte, 3U);
    EXPECT_EQ(frames[1].first_byte, 4 + kFrame.size());
    EXPECT_EQ(frames[1].length, kFrame.size());
    EXPECT_EQ(frames[1].channels.received, Instant(Duration(5)));
    EXPECT_TRUE(frames[1].channels.good());
    EXPECT_EQ(decoder.skipped_bytes(), 4U);
}

TEST(FramedDecoder, PassesOverAFrameThatSaysNothingOfChannels) {
    TinyDecoder decoder;
    Bytes bytes = tiny_frame({});
    append(bytes, kFrame);
    append(bytes, tiny_frame({}));
    const auto frames = feed(decoder, bytes);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].first_byte, 3U);
    EXPECT_EQ(decoder.skipped_bytes(), 0U);
    EXPECT_EQ(count_of(decoder, "checksum"), 0U);
}

TEST(FramedDecoder, FindsTheSameFramesHoweverReadsCutTheStream) {
    expect_the_same_however_cut(make<TinyDecoder>, frames_full_of_beginnings(1, 200).bytes, 200);
}

TEST(FramedDecoder, RefusesAFrameWhoseCheckIsWrong) {
    expect_each_flipped_bit_is_refused(make<TinyDecoder>, kFrame, kFrame);
}

TEST(FramedDecoder, CountsWhatItRefuses) {
    TinyDecoder decoder;
    Bytes bytes = kFrame;
    ++bytes.back();
    feed(decoder, bytes);
    decoder.damaged_byte();
    EXPECT_EQ(count_of(decoder, "checksum"), 1U);
    EXPECT_EQ(count_of(decoder, "damaged"), 1U);
}

TEST(FramedDecoder, AFaultCostsOnlyFramesThatItTouchesOnceTheLineIsSilent) {
    const FrameStream stream = frames_full_of_beginnings(2, 3);
    TinyDecoder unhurt;
    const auto clean = feed(unhurt, stream.bytes);
    for (std::size_t at = 0; at < stream.bytes.size(); ++at) {
        for (const FaultKind kind : {FaultKind::lost, FaultKind::added, FaultKind::damaged}) {
            const Fault fault{kind, at, 0x5A};
            TinyDecoder decoder;
            const auto frames = all_frames(decoder, stream.bytes, kOneRead, fault);
            const Damage damage = compare(stream, fault, clean, frames);
            EXPECT_LE(damage.missing.size(), 1U) << fault;
            EXPECT_EQ(decoder.waiting(), 0U) << fault;
        }
    }
}

TEST(FramedDecoder, AFrameHasNoDamagedByte) {
    const FrameStream stream = frames_full_of_beginnings(3, 300);
    Random random(4);
    TinyDecoder decoder;
    expect_no_frame_over_damage(decoder, stream.bytes, random, 40);
}

TEST(FramedDecoder, AFrameOfNinetyBytesWithADamagedLastByteIsNone) {
    TinyDecoder decoder;
    const Bytes frame = tiny_frame(Bytes(87, 1));
    EXPECT_TRUE(feed(decoder, frame, {FaultKind::damaged, frame.size() - 1, 0}, kOneRead).empty());
    EXPECT_EQ(feed(decoder, frame).size(), 1U);
}

TEST(FramedDecoder, APauseEndsAnIncompleteFrame) {
    expect_a_pause_ends_a_frame(make<TinyDecoder>, kFrame, kFrame);
}

TEST(FramedDecoder, ForgetsWhatAnUnpluggedLineSent) {
    TinyDecoder decoder;
    feed(decoder, std::span(kFrame).first(4));
    decoder.reset();
    EXPECT_TRUE(feed(decoder, std::span(kFrame).subspan(4)).empty());
}

}  // namespace
}  // namespace tribus::test::framed_decoder_test
