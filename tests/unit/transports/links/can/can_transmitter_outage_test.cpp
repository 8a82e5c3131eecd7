#include "transports/links/can/can_transmitter.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

/// A transmitter remembers some trouble of the bus and forgets other.
namespace tribus::can_transmitter_outage_test {
namespace {

using namespace std::chrono_literals;

CanFrame frame(std::uint32_t id) {
    CanFrame made;
    made.id = id;
    made.length = 1;
    return made;
}

class CanTransmitterOutage : public ::testing::Test {
  protected:
    WriteStatus offer(std::size_t lane, std::uint32_t first_id, std::size_t count = 1) {
        std::vector<CanFrame> frames;
        for (std::size_t part = 0; part < count; ++part) {
            frames.push_back(frame(first_id + static_cast<std::uint32_t>(part)));
        }
        return transmitter_.offer(lane, frames, now_);
    }
    /// How many frames are to go now; the kernel takes them.
    std::size_t hand_over() {
        const std::size_t count = transmitter_.next(now_).size();
        if (count > 0) {
            transmitter_.handed(count, now_);
        }
        return count;
    }
    void confirm(std::uint32_t id) { transmitter_.confirmed(frame(id), now_); }
    /// A frame is sent without errors, so that whole snapshots go from now on.
    void prove_bus() {
        offer(16, 0x700);
        hand_over();
        confirm(0x700);
        counts_ = {};
    }
    /// The kernel has no room for the frame that is to go.
    void refuse_as_full() {
        ASSERT_FALSE(transmitter_.next(now_).empty());
        transmitter_.refused_full(now_);
    }
    void down_and_up() {
        transmitter_.went_down();
        transmitter_.came_up(now_);
        now_ += CanTransmitter::kSettlingTime;
    }
    void wait_too_long() {
        now_ += CanTransmitter::kMostWait;
        transmitter_.poll(now_);
    }

    CanCounts counts_;
    CanTransmitter transmitter_{counts_, true};
    Instant now_ = Instant(1h);
};

TEST_F(CanTransmitterOutage, ASnapshotThatNobodyFetchedIsAbandonedWithoutAStall) {
    offer(0, 0x300);
    wait_too_long();
    EXPECT_EQ(counts_.abandoned, 1U);
    EXPECT_EQ(counts_.stalls, 0U);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
}

TEST_F(CanTransmitterOutage, AFullQueueThatTookAFrameAfterAllIsForgotten) {
    offer(0, 0x300);
    refuse_as_full();
    now_ += CanTransmitter::kFullRetry;
    EXPECT_EQ(hand_over(), 1U);
    offer(1, 0x400);
    now_ += 49ms;
    confirm(0x300);
    now_ += 1ms;
    transmitter_.poll(now_);
    EXPECT_EQ(counts_.abandoned, 1U);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
}

TEST_F(CanTransmitterOutage, AQueueThatStaysFullIsOneStallForAllLanes) {
    offer(0, 0x300);
    offer(1, 0x400);
    refuse_as_full();
    wait_too_long();
    EXPECT_EQ(transmitter_.state(), CanBusState::stalled);
    EXPECT_EQ(counts_.stalls, 1U);
    EXPECT_EQ(counts_.abandoned, 2U);
}

TEST_F(CanTransmitterOutage, AStallIsCountedOnce) {
    offer(0, 0x300);
    hand_over();
    wait_too_long();
    wait_too_long();
    EXPECT_EQ(counts_.stalls, 1U);
}

TEST_F(CanTransmitterOutage, AStallEndsYoungerSnapshotsToo) {
    offer(0, 0x300);
    hand_over();
    now_ += 40ms;
    offer(1, 0x400);
    now_ += 10ms;
    transmitter_.poll(now_);
    EXPECT_EQ(counts_.abandoned, 1U);
    EXPECT_EQ(transmitter_.due(), kNever);
}

TEST_F(CanTransmitterOutage, AFrameInFlightIsDueWhenItHasWaitedTooLong) {
    offer(0, 0x300);
    hand_over();
    EXPECT_EQ(transmitter_.due(), now_ + CanTransmitter::kMostWait);
}

TEST_F(CanTransmitterOutage, ASnapshotThatWaitsIsDueBeforeAFrameThatWasConfirmedSince) {
    prove_bus();
    offer(0, 0x300, 2);
    hand_over();
    offer(1, 0x400);
    const Instant offered = now_;
    now_ += 10ms;
    confirm(0x300);
    EXPECT_EQ(transmitter_.due(), offered + CanTransmitter::kMostWait);
}

TEST_F(CanTransmitterOutage, AfterAStallWhoseFrameWasLostTheFirstFrameGoesAlone) {
    prove_bus();
    offer(0, 0x300);
    hand_over();
    wait_too_long();
    transmitter_.forget_flight();
    offer(0, 0x300, 2);
    EXPECT_EQ(hand_over(), 1U);
}

TEST_F(CanTransmitterOutage, OneFrameOfAFlightProvesNothingWhereTheOthersAreLost) {
    prove_bus();
    offer(0, 0x300, 2);
    hand_over();
    transmitter_.error_level(CanTransmitter::ErrorLevel::warning);
    transmitter_.error_level(CanTransmitter::ErrorLevel::active);
    confirm(0x300);
    transmitter_.forget_flight();
    offer(0, 0x300, 2);
    EXPECT_EQ(hand_over(), 1U);
}

TEST_F(CanTransmitterOutage, GoingDownEndsABusOffForWhenItIsUpAgain) {
    transmitter_.bus_off(now_);
    transmitter_.went_down();
    EXPECT_EQ(transmitter_.state(), CanBusState::down);
    transmitter_.came_up(now_);
    now_ += CanTransmitter::kSettlingTime;
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    EXPECT_EQ(offer(0, 0x300), WriteStatus::written);
    EXPECT_EQ(hand_over(), 1U);
}

TEST_F(CanTransmitterOutage, GoingDownForgetsTheErrorsOfTheController) {
    transmitter_.error_level(CanTransmitter::ErrorLevel::passive);
    down_and_up();
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
}

TEST_F(CanTransmitterOutage, GoingDownForgetsAStall) {
    offer(0, 0x300);
    hand_over();
    wait_too_long();
    down_and_up();
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    EXPECT_EQ(offer(0, 0x300), WriteStatus::written);
}

TEST_F(CanTransmitterOutage, GoingDownForgetsAQueueThatStayedFull) {
    offer(0, 0x300);
    refuse_as_full();
    wait_too_long();
    ASSERT_EQ(transmitter_.state(), CanBusState::stalled);
    down_and_up();
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
}

TEST_F(CanTransmitterOutage, GoingDownForgetsThatTheQueueWasFull) {
    offer(0, 0x300);
    refuse_as_full();
    down_and_up();
    offer(0, 0x300);
    wait_too_long();
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    EXPECT_EQ(counts_.stalls, 0U);
}

TEST_F(CanTransmitterOutage, WhileDownNothingIsDue) {
    offer(0, 0x300);
    transmitter_.went_down();
    offer(0, 0x300);
    EXPECT_EQ(transmitter_.due(), kNever);
    EXPECT_EQ(hand_over(), 0U);
}

TEST_F(CanTransmitterOutage, AnInterfaceThatWasUpDoesNotComeUpAnew) {
    transmitter_.bus_off(now_);
    transmitter_.came_up(now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::bus_off);
    transmitter_.restarted(now_);
    now_ += CanTransmitter::kSettlingTime;
    transmitter_.came_up(now_);
    offer(0, 0x300);
    EXPECT_EQ(hand_over(), 1U) << "nothing has to settle";
}

TEST_F(CanTransmitterOutage, ARestartForgetsErrorsAndSettles) {
    transmitter_.error_level(CanTransmitter::ErrorLevel::passive);
    transmitter_.bus_off(now_);
    transmitter_.restarted(now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    offer(0, 0x300);
    EXPECT_EQ(transmitter_.due(), now_ + CanTransmitter::kSettlingTime);
    EXPECT_EQ(hand_over(), 0U);
    now_ += CanTransmitter::kSettlingTime;
    EXPECT_EQ(hand_over(), 1U);
}

TEST_F(CanTransmitterOutage, ABusOffThatIsReportedAgainIsCountedOnceAndDelaysNoProbe) {
    transmitter_.bus_off(now_);
    now_ += 1s;
    transmitter_.bus_off(now_);
    EXPECT_EQ(counts_.bus_offs, 1U);
    now_ += 1s;
    EXPECT_EQ(offer(0, 0x300), WriteStatus::written);
}

TEST_F(CanTransmitterOutage, ABusOffEndsAStall) {
    offer(0, 0x300);
    hand_over();
    wait_too_long();
    transmitter_.bus_off(now_);
    transmitter_.alive(now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
}

TEST_F(CanTransmitterOutage, TheNextProbeComesAPeriodAfterTheOneBefore) {
    transmitter_.bus_off(now_);
    now_ += CanTransmitter::kProbePeriod;
    EXPECT_EQ(offer(0, 0x300), WriteStatus::written);
    transmitter_.next(now_);
    transmitter_.refused();
    now_ += CanTransmitter::kProbePeriod - 1ns;
    EXPECT_EQ(offer(0, 0x300), WriteStatus::unavailable);
    now_ += 1ns;
    EXPECT_EQ(offer(0, 0x300), WriteStatus::written);
}

TEST_F(CanTransmitterOutage, WhileTheControllerHoldsAFrameInABusOffNothingIsDue) {
    offer(0, 0x300);
    hand_over();
    transmitter_.bus_off(now_);
    EXPECT_EQ(transmitter_.due(), kNever);
}

TEST_F(CanTransmitterOutage, AfterASignOfLifeTheNextFrameThatDoesNotLeaveIsAStall) {
    offer(0, 0x300);
    hand_over();
    transmitter_.bus_off(now_);
    transmitter_.alive(now_);
    confirm(0x300);
    offer(0, 0x300);
    EXPECT_EQ(hand_over(), 1U);
    wait_too_long();
    EXPECT_EQ(transmitter_.state(), CanBusState::stalled);
    EXPECT_EQ(counts_.stalls, 1U);
}

TEST_F(CanTransmitterOutage, AllFramesThatLeftAtOnceAreCounted) {
    prove_bus();
    offer(0, 0x300, 3);
    hand_over();
    transmitter_.confirmed_all();
    EXPECT_EQ(counts_.confirmed, 3U);
    EXPECT_FALSE(transmitter_.in_flight());
}

TEST_F(CanTransmitterOutage, WhatLeftAtOnceEndsAStallAndABusOff) {
    offer(0, 0x300);
    hand_over();
    wait_too_long();
    transmitter_.confirmed_all();
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    offer(0, 0x300);
    hand_over();
    transmitter_.bus_off(now_);
    transmitter_.confirmed_all();
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
}

TEST_F(CanTransmitterOutage, TheOldestSnapshotIsDueFirst) {
    offer(0, 0x300);
    hand_over();
    now_ += 10ms;
    confirm(0x300);
    offer(0, 0x300);
    refuse_as_full();
    now_ += CanTransmitter::kFullRetry;
    EXPECT_EQ(hand_over(), 1U);
    const Instant in_flight_since = now_;
    EXPECT_EQ(transmitter_.in_flight_since(), in_flight_since);
    offer(1, 0x400);
    now_ += 10ms;
    offer(2, 0x500);
    EXPECT_EQ(transmitter_.due(), in_flight_since + CanTransmitter::kMostWait);
    confirm(0x300);
    EXPECT_EQ(transmitter_.due(), in_flight_since) << "it could have gone then";
}

TEST_F(CanTransmitterOutage, TakesSixteenFramesAndTheLastLane) {
    prove_bus();
    EXPECT_EQ(offer(16, 0x300, 16), WriteStatus::written);
    EXPECT_EQ(hand_over(), 16U);
    EXPECT_EQ(counts_.sent, 16U);
}

}  // namespace
}  // namespace tribus::can_transmitter_outage_test
