#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include "tests/support/heap_trap.h"
#include "tests/support/streams.h"
#include "transports/codecs/dronecan/transfer.h"

namespace tribus::dronecan::dronecan_transfer_test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kSignature = 0x771555E596AAB4CF;
constexpr std::size_t kMostBytes = 53;

/// The receiver takes every path: more senders than it has room for, both kinds of frames, losses,
/// pauses of more than 2 s and payloads that are too long.
TEST(DronecanTransfer, NeitherSideAllocatesOnceItIsMade) {
    TransferReceiver receiver(
        {{.data_type_id = 1140, .signature = kSignature, .most_bytes = kMostBytes},
         {.data_type_id = 1, .most_bytes = 7}},
        3);
    test::Random random(7);
    std::array<CanFrame, 16> frames;
    std::array<std::uint8_t, 64> payload{};
    std::uint64_t frame_total = 0;
    Instant now{1000s};
    const test::HeapTrap trap;
    for (std::uint32_t turn = 0; turn < 20'000; ++turn) {
        const bool anonymous = random.below(8) == 0;
        const TransferHead head{
            .data_type_id = static_cast<std::uint16_t>(anonymous ? 1 : 1140),
            .source = anonymous ? kNobody : static_cast<NodeId>(1 + random.below(5)),
            .transfer_id = static_cast<std::uint8_t>(turn / 4 % 32)};
        const auto bytes = std::span(payload).first(random.below(anonymous ? 8 : 65));
        now += random.below(32) == 0 ? Duration{1s} : Duration{5ms};
        const std::size_t count =
            encode_transfer(head, kSignature, bytes, random.below(2) == 0, frames);
        for (const CanFrame& frame : std::span(frames).first(count)) {
            if (random.below(64) != 0) {
                receiver.take(frame, now);
                ++frame_total;
            }
        }
    }
    EXPECT_EQ(trap.allocations(), 0U);
    std::uint64_t result_total = 0;
    for (const std::uint64_t count : receiver.counts()) {
        result_total += count;
    }
    EXPECT_EQ(result_total, frame_total);
    for (const FrameResult result :
         {FrameResult::taken, FrameResult::complete, FrameResult::repeated,
          FrameResult::out_of_turn, FrameResult::bad_crc, FrameResult::too_long,
          FrameResult::crowded_out}) {
        EXPECT_GT(receiver.counts()[static_cast<std::size_t>(result)], 0U)
            << "result " << static_cast<int>(result);
    }
    EXPECT_GT(receiver.broken_off(), 0U);
}

}  // namespace
}  // namespace tribus::dronecan::dronecan_transfer_test
