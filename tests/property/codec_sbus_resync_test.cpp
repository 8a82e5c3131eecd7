#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/sbus_streams.h"
#include "tests/support/streams.h"
#include "transports/codecs/sbus/sbus.h"

namespace tribus::codec_sbus_resync_test {
namespace {

using test::all_sticks;
using test::Fault;
using test::FaultKind;
using test::feed;
using test::feed_into;
using test::FrameStream;
using test::SbusSticks;

/// Of the six frames two lock the decoder, one is hit, one follows, and two must arrive, each the
/// other's proof.
constexpr std::size_t kHitFrame = 2;
constexpr std::uint32_t kFrames = 6;
/// Highest flags in the test. With all four bits set the flag byte is 0F, which is also the header.
/// With still sticks, an added byte then gives the same bytes as a frame lost earlier, if the
/// payload continues like a frame. No reader can tell the two apart, so 0F is left out.
constexpr std::uint8_t kFlagsThatAreNoHeader = 15;

/// Upper limits of what one fault may cost.
struct Cost {
    std::size_t first;     ///< first frame that may be missing
    std::size_t last;      ///< last frame that may be missing
    std::size_t invented;  ///< frames that may appear instead of the missing ones
};

class SbusResync {
  public:
    SbusResync(std::string name, FrameStream stream)
        : name_(std::move(name)), stream_(std::move(stream)) {
        SbusDecoder decoder;
        clean_ = feed(decoder, stream_.bytes);
    }

    bool decodes_without_a_fault() const {
        return std::ranges::equal(clean_, stream_.starts, {}, &DecodedFrame::first_byte);
    }

    void hit(const Fault& fault, const Cost& cost, test::Split split = test::kOneRead) const {
        SbusDecoder decoder;
        const auto decoded = feed(decoder, stream_.bytes, fault, split);
        const test::Damage damage = compare(stream_, fault, clean_, decoded);
        const bool affordable = std::ranges::all_of(damage.missing, [&](std::size_t frame) {
            return frame >= cost.first && frame <= cost.last;
        });
        if (!affordable || damage.invented > cost.invented) {
            ADD_FAILURE() << name_ << ", " << fault << ": missing "
                          << ::testing::PrintToString(damage.missing) << ", " << damage.invented
                          << " invented";
        }
    }

    /// Tries each fault of every kind with `values` at byte `offset` of the hit frame.
    void hit_with(std::span<const std::uint8_t> values, std::size_t offset) const {
        const std::size_t position = place(offset);
        hit({FaultKind::lost, position, 0}, kFrameAndNext);
        hit({FaultKind::damaged, position, 0}, kOnlyFrame);
        for (const std::uint8_t value : values) {
            // A header added before a header makes a frame that starts one byte early.
            hit({FaultKind::added, position, value},
                {kHitFrame, kHitFrame + 1, offset == 0 ? std::size_t{1} : 0});
            hit({FaultKind::replaced, position, value}, kFrameAndNext);
        }
    }

    std::size_t place(std::size_t offset) const { return stream_.starts[kHitFrame] + offset; }

    static constexpr Cost kOnlyFrame{kHitFrame, kHitFrame, 0};
    static constexpr Cost kFrameAndNext{kHitFrame, kHitFrame + 1, 0};

  private:
    std::string name_;
    FrameStream stream_;
    std::vector<DecodedFrame> clean_;
};

std::vector<std::uint8_t> all_values() {
    std::vector<std::uint8_t> values;
    for (unsigned value = 0; value < 256; ++value) {
        values.push_back(static_cast<std::uint8_t>(value));
    }
    return values;
}

/// Returns one byte of each kind that a decoder distinguishes: header, allowed flags or not,
/// allowed footer or not, slot ids.
std::vector<std::uint8_t> telling_values() {
    return {0x00, 0x03, 0x04, 0x0F, 0x10, 0x83, 0xFF};
}

TEST(SbusResyncProperty, AnyByteAtAnyOffsetCostsTheFrameItHitsAndTheNext) {
    for (const SbusSticks& sticks : test::hard_sticks_that_stand_still()) {
        const SbusResync resync(sticks.name, test::sbus_stream(sticks, 0x00, kFrames));
        ASSERT_TRUE(resync.decodes_without_a_fault()) << sticks.name;
        for (std::size_t offset = 0; offset < kSbusFrameLength; ++offset) {
            resync.hit_with(all_values(), offset);
        }
    }
}

TEST(SbusResyncProperty, SoWithAllFlags) {
    for (const SbusSticks& sticks : all_sticks(1)) {
        for (std::uint8_t flags = 0; flags < kFlagsThatAreNoHeader; ++flags) {
            const SbusResync resync(sticks.name + ", flags " + std::to_string(flags),
                                    test::sbus_stream(sticks, flags, kFrames));
            ASSERT_TRUE(resync.decodes_without_a_fault()) << sticks.name;
            for (std::size_t offset = 0; offset < kSbusFrameLength; ++offset) {
                resync.hit_with(telling_values(), offset);
            }
        }
    }
}

TEST(SbusResyncProperty, SoHoweverTheStreamIsCut) {
    for (const SbusSticks& sticks : all_sticks(2)) {
        const SbusResync resync(sticks.name, test::sbus_stream(sticks, 0x0C, kFrames));
        for (std::size_t offset = 0; offset < kSbusFrameLength; ++offset) {
            for (const test::Split split : {test::kByteByByte, test::Split{60, 3}}) {
                const std::size_t position = resync.place(offset);
                resync.hit({FaultKind::lost, position, 0}, SbusResync::kFrameAndNext, split);
                resync.hit({FaultKind::added, position, 0x04}, SbusResync::kFrameAndNext, split);
                resync.hit({FaultKind::damaged, position, 0}, SbusResync::kOnlyFrame, split);
            }
        }
    }
}

/// Left out on SBUS2: a header that became a slot's id, and a header among the slots. Both shift
/// the slots, and a payload that continues like a frame from there deceives every reader.
bool looks_like_a_slot(std::uint8_t value) {
    return value % 8 == 3;
}

TEST(SbusResyncProperty, AByteInAnSbus2FrameCostsItAndTheNext) {
    for (const SbusSticks& sticks : test::hard_sticks_that_stand_still()) {
        for (const std::uint32_t triples : {0U, 1U, 8U}) {
            const SbusResync resync(sticks.name + ", slots " + std::to_string(triples),
                                    test::sbus2_stream(sticks, 0x00, kFrames, triples));
            ASSERT_TRUE(resync.decodes_without_a_fault()) << sticks.name;
            for (std::size_t offset = 0; offset < kSbusFrameLength; ++offset) {
                auto values = telling_values();
                if (offset == 0) {
                    std::erase_if(values, looks_like_a_slot);
                }
                resync.hit_with(values, offset);
            }
        }
    }
}

TEST(SbusResyncProperty, AByteInASlotCostsTheFrameBehindAndTheNext) {
    constexpr Cost kBehindAndNext{kHitFrame + 1, kHitFrame + 2, 1};
    auto values = telling_values();
    std::erase(values, 0x0F);
    for (const SbusSticks& sticks : test::hard_sticks_that_stand_still()) {
        for (const std::uint32_t triples : {1U, 8U}) {
            const SbusResync resync(sticks.name + ", slots " + std::to_string(triples),
                                    test::sbus2_stream(sticks, 0x00, kFrames + 1, triples));
            for (std::size_t offset = 0; offset < 3 * triples; ++offset) {
                const std::size_t position = resync.place(kSbusFrameLength + offset);
                resync.hit({FaultKind::lost, position, 0}, kBehindAndNext);
                resync.hit({FaultKind::damaged, position, 0}, kBehindAndNext);
                for (const std::uint8_t value : values) {
                    resync.hit({FaultKind::added, position, value}, kBehindAndNext);
                    resync.hit({FaultKind::replaced, position, value}, kBehindAndNext);
                }
            }
        }
    }
}

TEST(SbusResyncProperty, TheFrameBehindADamagedOneComesWithItsLastByte) {
    for (const SbusSticks& sticks : all_sticks(3)) {
        const FrameStream stream = test::sbus_stream(sticks, 0x00, 5);
        const auto all = std::span<const std::uint8_t>(stream.bytes);
        for (std::size_t offset = 0; offset < kSbusFrameLength; ++offset) {
            SbusDecoder decoder;
            std::vector<DecodedFrame> frames;
            feed_into(frames, decoder, all.first(stream.starts[2] + offset));
            decoder.damaged_byte();
            feed_into(
                frames, decoder,
                all.subspan(stream.starts[2] + offset + 1, 2 * kSbusFrameLength - offset - 1));
            ASSERT_EQ(frames.size(), 3U) << sticks.name << ", offset " << offset;
            ASSERT_EQ(frames.back().first_byte, stream.starts[3]);
        }
    }
}

}  // namespace
}  // namespace tribus::codec_sbus_resync_test
