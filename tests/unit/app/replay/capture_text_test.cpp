#include "app/replay/capture_text.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "transports/recordings/recording.h"

namespace tribus::capture_text_test {
namespace {

using namespace std::chrono_literals;

constexpr Duration kByteTime = 100us;
constexpr Instant kZero{1s};

/// Records into a ring and returns the content as text.
class Passing {
  public:
    explicit Passing(bool can)
        : text_({.can = can,
                 .interface = can ? "can0" : "",
                 .byte_time = kByteTime,
                 .zero = kZero,
                 .zero_wall = 1'436'509'052s}) {}

    CaptureRing& ring() { return ring_; }
    const std::string& read() { return finished().read(); }
    const std::string& written() { return finished().written(); }

  private:
    struct alignas(64) Line {
        std::array<std::byte, 64> bytes{};
    };
    CaptureText& finished() {
        std::vector<CapturePiece> pieces(64);
        const auto batch = ring_.read(next_, pieces);
        next_ = batch.first + batch.count;
        text_.take(std::span(pieces).first(batch.count));
        text_.finish();
        return text_;
    }

    std::vector<Line> memory_ = std::vector<Line>(65);
    CaptureRing ring_ = CaptureRing::create(std::as_writable_bytes(std::span(memory_)));
    std::uint64_t next_ = 0;
    CaptureText text_;
};

Reception reception_of(std::initializer_list<std::uint8_t> bytes) {
    Reception reception;
    for (const std::uint8_t byte : bytes) {
        reception.bytes[reception.count++] = byte;
    }
    return reception;
}

TEST(CaptureText, TellsWhenTheFirstByteOfAReadBegan) {
    Passing passing(false);
    passing.ring().record(reception_of({0x20, 0x40}), kZero + 7ms);
    EXPECT_EQ(passing.read(), "# t_us  bytes\n6800 20 40\n");
}

TEST(CaptureText, TellsWhenAWriteWasHandedOver) {
    Passing passing(false);
    passing.ring().record(std::vector<std::uint8_t>{0x0f, 0x00}, kZero + 7ms);
    EXPECT_EQ(passing.written(), "# t_us  bytes\n7000 0f 00\n");
    EXPECT_EQ(passing.read(), "# t_us  bytes\n");
}

TEST(CaptureText, MarksBytesThatCameDamaged) {
    Passing passing(false);
    Reception reception = reception_of({0x20, 0x40, 0xdc});
    reception.damaged.set(1);
    passing.ring().record(reception, kZero + 7ms);
    EXPECT_EQ(passing.read(), "# t_us  bytes\n6700 20 40! dc\n");
}

TEST(CaptureText, IsOneLineForALongRead) {
    Passing passing(false);
    Reception reception;
    reception.count = 100;
    passing.ring().record(reception, kZero + 20ms);
    const auto recording = parse_recording(passing.read(), "t");
    ASSERT_TRUE(recording) << recording.error();
    ASSERT_EQ(recording->bursts.size(), 1U);
    EXPECT_EQ(recording->bursts[0].bytes.size(), 100U);
}

TEST(CaptureText, NeverGoesBackInTime) {
    Passing passing(false);
    passing.ring().record(reception_of({1, 2, 3, 4}), kZero + 7ms);
    passing.ring().record(reception_of({5, 6, 7, 8}), kZero + 7100us);
    EXPECT_EQ(passing.read(), "# t_us  bytes\n6600 01 02 03 04\n7000 05 06 07 08\n");
}

TEST(CaptureText, LeavesOutWhatCameBeforeTheZero) {
    Passing passing(false);
    passing.ring().record(reception_of({1}), kZero - 1ms);
    passing.ring().record(reception_of({2}), kZero + 1ms);
    EXPECT_EQ(passing.read(), "# t_us  bytes\n900 02\n");
}

TEST(CaptureText, IsALogForCanWhoseZeroIsThatOfTheRecording) {
    Passing passing(true);
    passing.ring().record(Direction::read, {.id = 0x123, .length = 2, .data = {0x11, 0x22}},
                          kZero + 250ms);
    passing.ring().record(Direction::written, {.id = 0x300, .remote = true, .length = 4},
                          kZero + 300ms);
    EXPECT_EQ(passing.read(), "# zero (1436509052.000000)\n(1436509052.250000) can0 123#1122\n");
    EXPECT_EQ(passing.written(), "# zero (1436509052.000000)\n(1436509052.300000) can0 300#R4\n");
    const auto recording = parse_recording(passing.read(), "t");
    ASSERT_TRUE(recording) << recording.error();
    EXPECT_EQ(recording->kind, RecordingKind::candump);
    EXPECT_EQ(recording->can_frames.at(0).at, 250ms);
}

TEST(CaptureText, KeepsAllBytesOfAnFdFrame) {
    Passing passing(true);
    CanFrame frame{.id = 0x123, .fd = true, .bit_rate_switch = true, .length = 64};
    for (std::size_t i = 0; i < frame.data.size(); ++i) {
        frame.data[i] = static_cast<std::uint8_t>(i);
    }
    passing.ring().record(Direction::read, frame, kZero + 1ms);
    const auto recording = parse_recording(passing.read(), "t");
    ASSERT_TRUE(recording) << recording.error();
    EXPECT_EQ(recording->can_frames.at(0).frame, frame);
}

}  // namespace
}  // namespace tribus::capture_text_test
