#include <gtest/gtest.h>

#include <vector>

#include "tests/support/ibus_frames.h"
#include "tests/support/streams.h"
#include "transports/codecs/ibus/ibus.h"

/// A single frame of another length is not accepted from an i.Bus sender; and the effects of a
/// pause.
namespace tribus::ibus_length_test {
namespace {

using test::append;
using test::Bytes;
using test::count_of;
using test::feed;
using test::feed_into;

/// Returns a frame with all channels at 1500 us.
Bytes frame_of(std::size_t channels) {
    Bytes slots;
    for (std::size_t i = 0; i < channels; ++i) {
        append(slots, test::from_hex("dc 05"));
    }
    return test::servo_frame(slots, 0x40);
}
// A frame of an IA6, 31 bytes (Betaflight's unit test).
Bytes ia6_frame() {
    return test::from_hex(
        "55 00 00 01 00 02 00 03 00 04 00 05 00 06 00 07 00 08 00 09 00 0a 00 0b 00 0c 00 0d 00 "
        "5b 00");
}
Bytes stream_of(const std::vector<Bytes>& frames) {
    Bytes bytes;
    for (const Bytes& frame : frames) {
        append(bytes, frame);
    }
    return bytes;
}

TEST(IbusLength, OneFrameOfAnotherLengthIsRejected) {
    const Bytes bytes = stream_of({frame_of(14), frame_of(1), frame_of(14), frame_of(14)});
    for (const test::Split split : {test::kOneRead, test::kByteByByte, test::Split{7}}) {
        IbusDecoder decoder;
        const auto frames = feed(decoder, bytes, split);
        ASSERT_EQ(frames.size(), 3U);
        EXPECT_EQ(frames[1].first_byte, 38U);
        EXPECT_EQ(count_of(decoder, "length"), 1U);
        EXPECT_EQ(decoder.skipped_bytes(), 6U);
    }
}

TEST(IbusLength, TheFirstFrameTellsIt) {
    for (const Bytes& first : {frame_of(1), frame_of(14), ia6_frame()}) {
        IbusDecoder decoder;
        EXPECT_EQ(feed(decoder, first).size(), 1U);
    }
}

TEST(IbusLength, AnotherOneCountsWithItsThirdFrameInARow) {
    for (const auto& [before, behind] :
         {std::pair{frame_of(14), frame_of(6)}, std::pair{frame_of(6), frame_of(14)},
          std::pair{ia6_frame(), frame_of(14)}}) {
        for (const test::Split split : {test::kOneRead, test::kByteByByte, test::Split{7}}) {
            IbusDecoder decoder;
            const auto frames =
                feed(decoder, stream_of({before, before, behind, behind, behind, behind}), split);
            ASSERT_EQ(frames.size(), 4U);
            EXPECT_EQ(frames[2].length, behind.size());
            EXPECT_EQ(count_of(decoder, "length"), 2U);
        }
    }
}

TEST(IbusLength, FramesOfAnotherLengthAmongTheUsualOnesNeverCount) {
    IbusDecoder decoder;
    Bytes bytes = frame_of(14);
    for (int i = 0; i < 50; ++i) {
        append(bytes, stream_of({frame_of(1), frame_of(1), frame_of(14)}));
    }
    EXPECT_EQ(feed(decoder, bytes).size(), 51U);
    EXPECT_EQ(count_of(decoder, "length"), 100U);
}

TEST(IbusLength, TwoOtherLengthsDoNotHelpEachOther) {
    IbusDecoder decoder;
    Bytes bytes = frame_of(14);
    for (int i = 0; i < 50; ++i) {
        append(bytes, stream_of({frame_of(1), frame_of(2)}));
    }
    EXPECT_EQ(feed(decoder, bytes).size(), 1U);
}

TEST(IbusLength, ADeviceThatIsBackMayHaveAnother) {
    IbusDecoder decoder;
    feed(decoder, stream_of({frame_of(14), frame_of(14)}));
    decoder.reset();
    EXPECT_EQ(feed(decoder, frame_of(6)).size(), 1U);
}

/// Returns the frames of the first piece, a pause, and the second piece.
std::vector<DecodedFrame> with_a_pause(IbusDecoder& decoder, const Bytes& first,
                                       const Bytes& second) {
    auto frames = feed(decoder, first);
    DecodedFrame frame;
    while (decoder.silence(frame)) {
        frames.push_back(frame);
    }
    feed_into(frames, decoder, second);
    return frames;
}

TEST(IbusPauses, AFrameThatIsCutOffCostsNoOther) {
    for (std::size_t cut = 1; cut < 32; ++cut) {
        Bytes torn = frame_of(14);
        torn.resize(cut);
        IbusDecoder decoder;
        const auto frames = with_a_pause(decoder, torn, frame_of(14));
        ASSERT_EQ(frames.size(), 1U) << cut;
        EXPECT_EQ(frames[0].first_byte, cut);
        EXPECT_EQ(decoder.skipped_bytes(), cut);
    }
}

TEST(IbusPauses, ItsRestBehindThePauseCompletesNothing) {
    const Bytes whole = frame_of(14);
    for (std::ptrdiff_t cut = 1; cut < 32; ++cut) {
        IbusDecoder decoder;
        ASSERT_TRUE(with_a_pause(decoder, {whole.begin(), whole.begin() + cut},
                                 {whole.begin() + cut, whole.end()})
                        .empty())
            << cut;
    }
}

TEST(IbusPauses, FramesInsideWhatLookedLikeALongerOneComeWithThePause) {
    Bytes bytes = test::from_hex("20 40");
    append(bytes, stream_of({frame_of(1), frame_of(1)}));
    IbusDecoder decoder;
    EXPECT_EQ(with_a_pause(decoder, bytes, {}).size(), 2U);
}

}  // namespace
}  // namespace tribus::ibus_length_test
