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
    std::uint64_t fate_total = 0;
    for (const std::uint64_t count : receiver.fates()) {
        fate_total += count;
    }
    EXPECT_EQ(fate_total, frame_total);
    for (const FrameFate fate :
         {FrameFate::taken, FrameFate::complete, FrameFate::repeated, FrameFate::out_of_turn,
          FrameFate::bad_crc, FrameFate::too_long, FrameFate::crowded_out}) {
        EXPECT_GT(receiver.fates()[static_cast<std::size_t>(fate)], 0U)
            << "fate " << static_cast<int>(fate);
    }
    EXPECT_GT(receiver.broken_off(), 0U);
}

}  // namespace
}  // namespace tribus::dronecan::dronecan_transfer_test
