#include "pipelines/realtime/capture_ring.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <numeric>
#include <thread>
#include <vector>

namespace tribus::capture_ring_test {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

/// Aligned memory for `pieces` pieces.
class Memory {
  public:
    explicit Memory(std::size_t pieces) : lines_(1 + pieces) {}
    std::span<std::byte> span() { return std::as_writable_bytes(std::span(lines_)); }

  private:
    struct alignas(64) Line {
        std::array<std::byte, 64> bytes{};
    };
    std::vector<Line> lines_;
};

std::vector<CapturePiece> all_of(const CaptureRing& ring) {
    std::vector<CapturePiece> pieces(static_cast<std::size_t>(ring.end() - ring.begin()));
    const auto batch = ring.read(0, pieces);
    pieces.resize(batch.count);
    return pieces;
}

Bytes counted_bytes(std::size_t count, std::uint8_t first = 0) {
    Bytes bytes(count);
    std::iota(bytes.begin(), bytes.end(), first);
    return bytes;
}

Bytes data_of(const CapturePiece& piece) {
    return {piece.data().begin(), piece.data().end()};
}

TEST(CaptureRing, IsEmptyAtFirst) {
    Memory memory(16);
    const CaptureRing ring = CaptureRing::create(memory.span());
    EXPECT_EQ(ring.end(), 0U);
    EXPECT_TRUE(all_of(ring).empty());
}

TEST(CaptureRing, KeepsWhatWasWrittenWithItsTime) {
    Memory memory(16);
    CaptureRing ring = CaptureRing::create(memory.span());
    ring.record(counted_bytes(25), Instant(7ms));
    const auto pieces = all_of(ring);
    ASSERT_EQ(pieces.size(), 1U);
    EXPECT_EQ(pieces[0].at(), Instant(7ms));
    EXPECT_EQ(pieces[0].direction(), Direction::written);
    EXPECT_EQ(data_of(pieces[0]), counted_bytes(25));
}

TEST(CaptureRing, KeepsWhichBytesOfAReadWereDamaged) {
    Memory memory(16);
    CaptureRing ring = CaptureRing::create(memory.span());
    Reception reception;
    reception.count = 50;
    reception.damaged.set(3);
    reception.damaged.set(42);
    ring.record(reception, Instant(1ms));
    const auto pieces = all_of(ring);
    ASSERT_EQ(pieces.size(), 2U);
    EXPECT_EQ(pieces[0].direction(), Direction::read);
    EXPECT_EQ(pieces[0].damaged, 1U << 3U);
    EXPECT_EQ(pieces[1].damaged, 1U << 2U);
}

TEST(CaptureRing, CutsALongReadIntoPiecesThatGoOn) {
    Memory memory(16);
    CaptureRing ring = CaptureRing::create(memory.span());
    Reception reception;
    reception.count = 100;
    ring.record(reception, Instant(1ms));
    const auto pieces = all_of(ring);
    ASSERT_EQ(pieces.size(), 3U);
    EXPECT_FALSE(pieces[0].has(CaptureMarks::kContinued));
    EXPECT_TRUE(pieces[1].has(CaptureMarks::kContinued));
    EXPECT_EQ(pieces[2].count, 20U);
}

TEST(CaptureRing, KeepsACanFrameAsItWas) {
    Memory memory(16);
    CaptureRing ring = CaptureRing::create(memory.span());
    CanFrame frame{.id = 0x12345678, .extended = true, .length = 3, .data = {1, 2, 3}};
    ring.record(Direction::read, frame, Instant(1ms));
    EXPECT_EQ(can_frame_of(all_of(ring).at(0)), frame);
}

TEST(CaptureRing, HoldsOnePieceLessThanItsPlaces) {
    Memory memory(16);
    CaptureRing ring = CaptureRing::create(memory.span());
    for (std::uint8_t i = 0; i < 40; ++i) {
        ring.record(Bytes{i}, Instant(1ms * i));
    }
    const auto pieces = all_of(ring);
    ASSERT_EQ(pieces.size(), 15U);
    EXPECT_EQ(data_of(pieces.front()), Bytes{25});
    EXPECT_EQ(data_of(pieces.back()), Bytes{39});
}

TEST(CaptureRing, ThatWasLeftBehindTellsTheSame) {
    Memory memory(16);
    CaptureRing ring = CaptureRing::create(memory.span());
    for (std::uint8_t i = 0; i < 20; ++i) {
        ring.record(Bytes{i}, Instant(1ms * i));
    }
    const auto left = CaptureRing::adopt(memory.span());
    ASSERT_TRUE(left);
    EXPECT_EQ(data_of(all_of(*left).back()), Bytes{19});
}

TEST(CaptureRing, IsNotFoundInOtherMemory) {
    Memory memory(16);
    EXPECT_FALSE(CaptureRing::adopt(memory.span()));
    EXPECT_FALSE(CaptureRing::adopt(memory.span().first(64)));
    CaptureRing::create(memory.span());
    EXPECT_FALSE(CaptureRing::adopt(memory.span().first(15 * 64)));
}

RC_GTEST_PROP(CaptureRing, GivesBackTheNewestOfWhatPassed, ()) {
    const auto places = *rc::gen::inRange<std::size_t>(16, 40);
    const auto lengths = *rc::gen::container<std::vector<std::size_t>>(
        rc::gen::inRange<std::size_t>(1, CapturePiece::kMostBytes + 1));
    Memory memory(places);
    CaptureRing ring = CaptureRing::create(memory.span());
    for (std::size_t i = 0; i < lengths.size(); ++i) {
        ring.record(counted_bytes(lengths[i], static_cast<std::uint8_t>(i)),
                    Instant(1us * static_cast<std::int64_t>(i)));
    }
    const auto pieces = all_of(ring);
    RC_ASSERT(pieces.size() == std::min(lengths.size(), places - 1));
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const std::size_t number = lengths.size() - pieces.size() + i;
        RC_ASSERT(pieces[i].at() == Instant(1us * static_cast<std::int64_t>(number)));
        RC_ASSERT(data_of(pieces[i]) ==
                  counted_bytes(lengths[number], static_cast<std::uint8_t>(number)));
    }
}

/// Everything in a piece has the same number. A reader that is sometimes overtaken must never see
/// two numbers in one piece.
TEST(CaptureRing, NeverShowsAPieceThatIsHalfOverwritten) {
    constexpr std::size_t kPlaces = 128;
    Memory memory(kPlaces);
    CaptureRing ring = CaptureRing::create(memory.span());
    std::atomic<bool> stop = false;
    std::thread writer([&] {
        for (std::uint32_t number = 0; !stop; ++number) {
            CanFrame frame;
            frame.id = number;
            frame.length = 8;
            frame.data.fill(static_cast<std::uint8_t>(number));
            ring.record(Direction::read, frame, Instant(Duration(number)));
        }
    });
    std::array<CapturePiece, 16> pieces;
    std::size_t seen = 0;
    for (std::size_t round = 0; seen < 100'000; ++round) {
        const std::uint64_t end = ring.end();
        const std::size_t back = round % kPlaces;
        const auto batch = ring.read(end > back ? end - back : 0, pieces);
        for (std::size_t i = 0; i < batch.count; ++i) {
            const CapturePiece& piece = pieces[i];
            const auto number = static_cast<std::uint32_t>(batch.first + i);
            ASSERT_EQ(piece.can_id, number);
            ASSERT_EQ(piece.at_ns, number);
            ASSERT_EQ(piece.bytes[0], static_cast<std::uint8_t>(number));
            ASSERT_EQ(piece.bytes[7], static_cast<std::uint8_t>(number));
        }
        seen += batch.count;
    }
    stop = true;
    writer.join();
}

/// Memory that another process left may contain one.
TEST(CaptureRing, PieceOfTheOtherKindOfPortCannotBeRecorded) {
    CapturePiece frame;
    frame.marks = CaptureMarks::kCan;
    frame.count = 8;
    EXPECT_TRUE(can_be_recorded(frame, true));
    EXPECT_FALSE(can_be_recorded(frame, false));
    CapturePiece bytes;
    bytes.count = 8;
    EXPECT_TRUE(can_be_recorded(bytes, false));
    EXPECT_FALSE(can_be_recorded(bytes, true));
}

}  // namespace
}  // namespace tribus::capture_ring_test
