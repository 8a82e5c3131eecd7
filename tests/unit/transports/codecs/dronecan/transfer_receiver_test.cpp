#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "tests/support/streams.h"
#include "transports/codecs/dronecan/transfer.h"

namespace tribus::dronecan::transfer_receiver_test {
namespace {

using namespace std::chrono_literals;
using test::Bytes;

constexpr std::uint64_t kSignature = 0x771555E596AAB4CF;
constexpr std::size_t kMostBytes = 40;
constexpr Instant kStart{1000s};

using Results = std::vector<FrameResult>;
constexpr auto kTaken = FrameResult::taken;
constexpr auto kComplete = FrameResult::complete;
constexpr auto kRepeated = FrameResult::repeated;
constexpr auto kOutOfTurn = FrameResult::out_of_turn;

Bytes numbered(std::size_t count, std::uint8_t first = 1) {
    Bytes bytes(count);
    std::iota(bytes.begin(), bytes.end(), first);
    return bytes;
}

struct Sent {
    std::uint8_t transfer_id = 0;
    NodeId source = 42;
    std::size_t bytes = 20;
    bool fd = false;
};

/// Returns the frames of a wanted message.
std::vector<CanFrame> frames_of(const Sent& sent) {
    const TransferHead head{
        .data_type_id = 1140, .source = sent.source, .transfer_id = sent.transfer_id};
    std::array<CanFrame, 16> frames;
    const std::size_t count =
        encode_transfer(head, kSignature, numbered(sent.bytes, sent.transfer_id), sent.fd, frames);
    return {frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count)};
}

CanFrame service_frame(TransferKind kind, NodeId destination) {
    const TransferHead head{
        .kind = kind, .data_type_id = 11, .source = 5, .destination = destination};
    std::array<CanFrame, 1> frames;
    encode_transfer(head, kSignature, {}, false, frames);
    return frames[0];
}

class DronecanReceiver : public testing::Test {
  protected:
    TransferReceiver::Taken take(const CanFrame& frame, Duration since_start = {}) {
        const auto taken = receiver_.take(frame, kStart + since_start);
        if (taken.transfer) {
            payloads_.emplace_back(taken.transfer->payload.begin(), taken.transfer->payload.end());
        }
        return taken;
    }
    Results results_of(std::span<const CanFrame> frames, Duration since_start = {}) {
        Results results;
        for (const CanFrame& frame : frames) {
            results.push_back(take(frame, since_start).result);
        }
        return results;
    }
    std::uint64_t count(FrameResult result) const {
        return receiver_.counts()[static_cast<std::size_t>(result)];
    }

    TransferReceiver receiver_{
        {{.data_type_id = 1140, .signature = kSignature, .most_bytes = kMostBytes},
         {.kind = TransferKind::request, .data_type_id = 11, .most_bytes = 0},
         {.data_type_id = 1, .most_bytes = 7}},
        2};
    std::vector<Bytes> payloads_;
};

TEST_F(DronecanReceiver, TellsWhenTheFirstFrameCame) {
    const auto frames = frames_of({});
    take(frames[0], 1ms);
    take(frames[1], 2ms);
    take(frames[2], 3ms);
    const auto taken = take(frames[3], 4ms);
    ASSERT_TRUE(taken.transfer);
    EXPECT_EQ(taken.transfer->first_at, kStart + 1ms);
    EXPECT_EQ(taken.transfer->head,
              (TransferHead{.data_type_id = 1140, .source = 42, .transfer_id = 0}));
    EXPECT_FALSE(taken.transfer->fd);
}

TEST_F(DronecanReceiver, FdPayloadKeepsItsPadding) {
    EXPECT_EQ(results_of(frames_of({.bytes = 9, .fd = true})), Results{kComplete});
    Bytes padded = numbered(9, 0);
    padded.resize(11);
    EXPECT_EQ(payloads_, std::vector<Bytes>{padded});
}

TEST_F(DronecanReceiver, NoPayloadIsLongerThanItsType) {
    const auto frames = frames_of({.bytes = kMostBytes, .fd = true});
    ASSERT_EQ(frames.at(0).length, 48);
    EXPECT_EQ(results_of(frames), Results{kComplete});
    EXPECT_EQ(payloads_, std::vector<Bytes>{numbered(kMostBytes, 0)});
}

TEST_F(DronecanReceiver, WhatIsTooLongForItsTypeIsRefusedAndTheNextIsTaken) {
    constexpr auto kTooLong = FrameResult::too_long;
    const Results expected{kTaken, kTaken, kTaken, kTaken, kTaken, kTaken, kTooLong};
    EXPECT_EQ(results_of(frames_of({.transfer_id = 1, .bytes = kMostBytes + 1})), expected);
    EXPECT_EQ(results_of(frames_of({.transfer_id = 2, .bytes = 48, .fd = true})),
              Results{kTooLong});
    EXPECT_EQ(results_of(frames_of({.transfer_id = 3, .bytes = 60})).back(), kTooLong);
    EXPECT_TRUE(payloads_.empty());
    EXPECT_EQ(results_of(frames_of({.transfer_id = 4, .bytes = kMostBytes})).back(), kComplete);
    EXPECT_EQ(receiver_.broken_off(), 0);
}

TEST_F(DronecanReceiver, ACopyOfASingleFrameIsPassedOverFor2Seconds) {
    const CanFrame frame = frames_of({.bytes = 7}).at(0);
    EXPECT_EQ(take(frame).result, kComplete);
    EXPECT_EQ(take(frame, 2s).result, kRepeated);
    EXPECT_EQ(take(frame, 2s + 1ns).result, kComplete);
}

TEST_F(DronecanReceiver, CopiesOfAnyFrameDoNotHarm) {
    Results results;
    for (const CanFrame& frame : frames_of({})) {
        results.push_back(take(frame).result);
        results.push_back(take(frame).result);
    }
    EXPECT_EQ(results, (Results{kTaken, kRepeated, kTaken, kRepeated, kTaken, kRepeated, kComplete,
                                kRepeated}));
    EXPECT_EQ(payloads_, std::vector<Bytes>{numbered(20, 0)});
}

// The specification's own pseudo code takes a start with the expected toggle bit for a continuation
// and loses the transfer.
TEST_F(DronecanReceiver, ALateCopyOfTheStartDoesNotHarm) {
    const auto frames = frames_of({});
    EXPECT_EQ(results_of(std::array{frames[0], frames[1], frames[0], frames[2], frames[3]}),
              (Results{kTaken, kTaken, kRepeated, kTaken, kComplete}));
}

// Here the pseudo code takes the third frame for the first one, which has the same toggle bit.
TEST_F(DronecanReceiver, AFrameWithoutAStartBeginsNothing) {
    EXPECT_EQ(results_of(frames_of({.transfer_id = 0})).back(), kComplete);
    const auto frames = frames_of({.transfer_id = 1});
    EXPECT_EQ(take(frames[2]).result, kOutOfTurn);
    EXPECT_EQ(results_of(frames), (Results{kTaken, kTaken, kTaken, kComplete}));
}

TEST_F(DronecanReceiver, AGapIsOutOfTurn) {
    const auto frames = frames_of({});
    EXPECT_EQ(results_of(std::array{frames[0], frames[2]}), (Results{kTaken, kOutOfTurn}));
    EXPECT_EQ(take(frames_of({.transfer_id = 9})[1]).result, kOutOfTurn);
}

TEST_F(DronecanReceiver, ASwapOfNeighboursCostsTheTransferOnly) {
    const auto frames = frames_of({});
    results_of(std::array{frames[0], frames[2], frames[1], frames[3]});
    EXPECT_TRUE(payloads_.empty());
    EXPECT_EQ(results_of(frames_of({.transfer_id = 1})).back(), kComplete);
}

TEST_F(DronecanReceiver, TellsThatTheTransferBeforeBrokeOff) {
    take(frames_of({.transfer_id = 4})[0]);
    const auto taken = take(frames_of({.transfer_id = 5})[0]);
    EXPECT_EQ(taken.result, kTaken);
    EXPECT_TRUE(taken.broke_off);
    EXPECT_EQ(receiver_.broken_off(), 1);
}

TEST_F(DronecanReceiver, ATransferThatTakesLongerThan2SecondsIsDead) {
    const auto frames = frames_of({});
    results_of(std::array{frames[0], frames[1]});
    const auto late = take(frames[2], 2s + 1ns);
    EXPECT_EQ(late.result, kOutOfTurn);
    EXPECT_TRUE(late.broke_off);
    EXPECT_EQ(take(frames[2]).result, kOutOfTurn) << "it does not live again";
    EXPECT_EQ(results_of(frames, 2s + 1ns).back(), kComplete);
}

TEST_F(DronecanReceiver, ATransferMayTake2Seconds) {
    const auto frames = frames_of({});
    results_of(std::span(frames).first(3));
    EXPECT_EQ(take(frames[3], 2s).result, kComplete);
}

TEST_F(DronecanReceiver, DamageIsABadCrc) {
    auto frames = frames_of({});
    frames[2].data[3] ^= 0x10U;
    EXPECT_EQ(results_of(frames).back(), FrameResult::bad_crc);
    EXPECT_TRUE(payloads_.empty());
}

TEST_F(DronecanReceiver, ClassicAndFdFramesMakeNoTransferTogether) {
    const auto classic = frames_of({.bytes = 8});
    CanFrame fd = classic.at(1);
    fd.fd = true;
    EXPECT_EQ(results_of(std::array{classic[0], fd}), (Results{kTaken, kOutOfTurn}));
}

TEST_F(DronecanReceiver, SendersBeyondTheRoomAreCrowdedOutUntilOneIsSilentFor2Seconds) {
    take(frames_of({.source = 1, .bytes = 7})[0], 1s);
    take(frames_of({.source = 2, .bytes = 7})[0], 2s);
    const auto third = frames_of({.source = 3});
    EXPECT_EQ(results_of(third, 3s), Results(4, FrameResult::crowded_out));
    EXPECT_EQ(results_of(third, 3s + 1ns).back(), kComplete);
    EXPECT_EQ(take(frames_of({.source = 1, .bytes = 7})[0], 3s + 2ns).result,
              FrameResult::crowded_out);
    EXPECT_EQ(take(frames_of({.source = 2, .bytes = 7})[0], 3s + 2ns).result, kRepeated)
        << "the one that was not silent kept its place";
}

TEST_F(DronecanReceiver, ASenderThatLosesItsPlaceInATransferBreaksOff) {
    take(frames_of({.source = 1})[0]);
    take(frames_of({.source = 2, .bytes = 7})[0], 2s);
    EXPECT_EQ(take(frames_of({.source = 3, .bytes = 7})[0], 3s).result, kComplete);
    EXPECT_EQ(receiver_.broken_off(), 1);
}

TEST_F(DronecanReceiver, EveryAnonymousMessageIsDeliveredAndNeedsNoPlace) {
    for (int sender = 0; sender < 5; ++sender) {
        const TransferHead head{.data_type_id = 1};
        std::array<CanFrame, 1> frames;
        encode_transfer(head, 0, numbered(7), false, frames);
        EXPECT_EQ(take(frames[0]).result, kComplete);
    }
    EXPECT_EQ(payloads_, std::vector<Bytes>(5, numbered(7)));
}

TEST_F(DronecanReceiver, AnonymousMessageThatIsTooLongIsRefused) {
    std::array<CanFrame, 1> frames;
    encode_transfer({.data_type_id = 1}, 0, numbered(8), true, frames);
    EXPECT_EQ(take(frames[0]).result, FrameResult::too_long);
}

TEST_F(DronecanReceiver, ServicesForAnotherNodeAreUnwantedWhenItKnowsItsOwn) {
    EXPECT_EQ(take(service_frame(TransferKind::request, 43)).result, kComplete);
    receiver_.set_own(42);
    EXPECT_EQ(take(service_frame(TransferKind::request, 43)).result, FrameResult::unwanted);
    EXPECT_EQ(take(service_frame(TransferKind::request, 42)).result, kComplete);
    EXPECT_EQ(results_of(frames_of({})).back(), kComplete) << "messages are for all";
}

TEST_F(DronecanReceiver, OtherTypesAndOtherKindsAreUnwanted) {
    EXPECT_EQ(take(service_frame(TransferKind::response, 42)).result, FrameResult::unwanted);
    CanFrame other = frames_of({}).at(0);
    other.id ^= 1U << 8U;
    EXPECT_EQ(take(other).result, FrameResult::unwanted);
    other.extended = false;
    EXPECT_EQ(take(other).result, FrameResult::foreign);
}

TEST_F(DronecanReceiver, CountsEveryFrameByWhatBecameOfIt) {
    results_of(frames_of({}));
    results_of(frames_of({}));
    take(CanFrame{});
    EXPECT_EQ(count(kTaken), 3);
    EXPECT_EQ(count(kComplete), 1);
    EXPECT_EQ(count(kRepeated), 4);
    EXPECT_EQ(count(FrameResult::foreign), 1);
    EXPECT_EQ(std::reduce(receiver_.counts().begin(), receiver_.counts().end()), 9);
}

TEST_F(DronecanReceiver, OutlivesBeingMoved) {
    const auto frames = frames_of({.bytes = 8});
    take(frames.at(0));
    TransferReceiver moved = std::move(receiver_);
    const auto taken = moved.take(frames.at(1), kStart);
    ASSERT_TRUE(taken.transfer);
    EXPECT_TRUE(std::ranges::equal(taken.transfer->payload, numbered(8, 0)));
}

}  // namespace
}  // namespace tribus::dronecan::transfer_receiver_test
