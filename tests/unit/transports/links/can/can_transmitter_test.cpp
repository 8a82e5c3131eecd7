#include "transports/links/can/can_transmitter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tribus::can_transmitter_test {
namespace {

using namespace std::chrono_literals;

CanFrame frame(std::uint32_t id, std::uint8_t value = 0) {
    CanFrame made;
    made.id = id;
    made.length = 1;
    made.data[0] = value;
    return made;
}

std::vector<CanFrame> snapshot(std::uint32_t first_id, std::size_t count, std::uint8_t value = 0) {
    std::vector<CanFrame> frames;
    for (std::size_t index = 0; index < count; ++index) {
        frames.push_back(frame(first_id + static_cast<std::uint32_t>(index), value));
    }
    return frames;
}

using Ids = std::vector<std::uint32_t>;

class CanTransmitterTest : public ::testing::Test {
  protected:
    WriteStatus offer(std::size_t lane, const std::vector<CanFrame>& frames) {
        return transmitter_.offer(lane, frames, now_);
    }
    /// Passes the frames to the kernel that are to go now, at most `room`. Returns their ids.
    Ids hand_over(std::size_t room = kMostSnapshotFrames) {
        const std::span<const CanFrame> next = transmitter_.next(now_);
        const std::span<const CanFrame> taken = next.first(std::min(room, next.size()));
        Ids ids;
        for (const CanFrame& one : taken) {
            ids.push_back(one.id);
        }
        if (!taken.empty()) {
            controller_.assign(taken.begin(), taken.end());
            transmitter_.handed(taken.size(), now_);
        }
        return ids;
    }
    /// The controller has sent the first of the frames that it holds.
    void confirm() {
        transmitter_.confirmed(controller_.front(), now_);
        controller_.erase(controller_.begin());
    }
    void confirm_all() {
        while (!controller_.empty()) {
            confirm();
        }
    }
    /// A frame is sent without errors, so that whole snapshots go from now on.
    void prove_bus() {
        offer(16, snapshot(0x700, 1));
        hand_over();
        confirm_all();
        counts_ = {};
    }
    void stall() {
        offer(0, snapshot(0x100, 1));
        hand_over();
        now_ += CanTransmitter::kMostWait;
        transmitter_.poll(now_);
    }
    void settle() { now_ += CanTransmitter::kSettlingTime; }

    CanCounts counts_;
    CanTransmitter transmitter_{counts_, true};
    Instant now_ = Instant(1h);
    std::vector<CanFrame> controller_;
};

TEST_F(CanTransmitterTest, HandsOverNothingBeforeAnOffer) {
    EXPECT_TRUE(transmitter_.next(now_).empty());
    EXPECT_EQ(transmitter_.due(), kNever);
}

TEST_F(CanTransmitterTest, HandsOverAWholeSnapshotAndTheNextOnlyWhenAllItsFramesHaveLeft) {
    prove_bus();
    EXPECT_EQ(offer(0, snapshot(0x300, 3)), WriteStatus::written);
    EXPECT_EQ(hand_over(), (Ids{0x300, 0x301, 0x302}));
    EXPECT_EQ(offer(0, snapshot(0x400, 2)), WriteStatus::written);
    const std::vector<CanFrame> in_flight = controller_;
    for (const CanFrame& sent : in_flight) {
        EXPECT_EQ(hand_over(), Ids{});
        transmitter_.confirmed(sent, now_);
    }
    EXPECT_EQ(hand_over(), (Ids{0x400, 0x401}));
    EXPECT_EQ(counts_.sent, 5U);
    EXPECT_EQ(counts_.confirmed, 3U);
}

TEST_F(CanTransmitterTest, BeforeAFrameWasConfirmedTheFirstGoesAlone) {
    offer(0, snapshot(0x300, 3));
    EXPECT_EQ(hand_over(), Ids{0x300});
    EXPECT_EQ(hand_over(), Ids{});
    offer(1, snapshot(0x400, 1));
    transmitter_.confirmed(frame(0x300), now_);
    EXPECT_EQ(hand_over(), (Ids{0x301, 0x302}));
}

TEST_F(CanTransmitterTest, WhileTheControllerCountsErrorsTheFirstFrameGoesAlone) {
    prove_bus();
    transmitter_.error_level(CanTransmitter::ErrorLevel::warning);
    for (int turn = 0; turn < 3; ++turn) {
        offer(0, snapshot(0x300, 3));
        EXPECT_EQ(hand_over(), Ids{0x300}) << turn;
        confirm_all();
        EXPECT_EQ(hand_over(), (Ids{0x301, 0x302})) << turn;
        confirm_all();
    }
    transmitter_.error_level(CanTransmitter::ErrorLevel::active);
    offer(0, snapshot(0x300, 2));
    EXPECT_EQ(hand_over(), Ids{0x300});
    confirm_all();
    EXPECT_EQ(hand_over(), Ids{0x301});
    confirm_all();
    offer(0, snapshot(0x300, 2));
    EXPECT_EQ(hand_over(), (Ids{0x300, 0x301}));
}

TEST_F(CanTransmitterTest, AfterABusOffTheFirstFrameGoesAlone) {
    prove_bus();
    transmitter_.bus_off(now_);
    transmitter_.restarted(now_);
    settle();
    offer(0, snapshot(0x300, 2));
    EXPECT_EQ(hand_over(), Ids{0x300});
}

TEST_F(CanTransmitterTest, AfterTheInterfaceWasDownTheFirstFrameGoesAlone) {
    prove_bus();
    transmitter_.went_down();
    transmitter_.came_up(now_);
    settle();
    offer(0, snapshot(0x300, 2));
    EXPECT_EQ(hand_over(), Ids{0x300});
}

TEST_F(CanTransmitterTest, AfterAQueueThatStayedFullTheFirstFrameGoesAlone) {
    prove_bus();
    offer(0, snapshot(0x300, 2));
    transmitter_.next(now_);
    transmitter_.refused_full(now_);
    now_ += CanTransmitter::kMostWait;
    offer(0, snapshot(0x300, 2));
    EXPECT_EQ(hand_over(), Ids{0x300});
}

TEST_F(CanTransmitterTest, WhereNothingIsConfirmedTheFirstFrameAlwaysGoesAlone) {
    CanTransmitter unsure(counts_, false);
    for (int turn = 0; turn < 2; ++turn) {
        unsure.offer(0, snapshot(0x300, 3), now_);
        EXPECT_EQ(unsure.next(now_).size(), 1U) << turn;
        unsure.handed(1, now_);
        EXPECT_EQ(unsure.next(now_).size(), 0U) << turn;
        unsure.confirmed_all();
        EXPECT_EQ(unsure.next(now_).size(), 2U) << turn;
        unsure.handed(2, now_);
        unsure.confirmed_all();
    }
}

TEST_F(CanTransmitterTest, WhatTheKernelDidNotTakeFollowsWhenTheFirstPartHasLeft) {
    prove_bus();
    offer(0, snapshot(0x300, 5));
    EXPECT_EQ(hand_over(3), (Ids{0x300, 0x301, 0x302}));
    EXPECT_EQ(offer(0, snapshot(0x300, 5)), WriteStatus::busy);
    EXPECT_EQ(hand_over(), Ids{});
    confirm_all();
    EXPECT_EQ(hand_over(), (Ids{0x303, 0x304}));
}

TEST_F(CanTransmitterTest, ConfirmationsMayComeInAnyOrder) {
    prove_bus();
    offer(0, snapshot(0x300, 3));
    hand_over();
    for (const std::uint32_t id : {0x302U, 0x300U, 0x301U}) {
        EXPECT_TRUE(transmitter_.in_flight());
        transmitter_.confirmed(frame(id), now_);
    }
    EXPECT_FALSE(transmitter_.in_flight());
}

TEST_F(CanTransmitterTest, FramesThatAreTheSameNeedAConfirmationEach) {
    prove_bus();
    offer(0, {frame(0x300), frame(0x300)});
    hand_over();
    transmitter_.confirmed(frame(0x300), now_);
    EXPECT_TRUE(transmitter_.in_flight());
    transmitter_.confirmed(frame(0x300), now_);
    EXPECT_FALSE(transmitter_.in_flight());
}

TEST_F(CanTransmitterTest, OneSnapshotIsInFlightOverAllLanes) {
    prove_bus();
    offer(0, snapshot(0x300, 2));
    offer(1, snapshot(0x400, 1));
    EXPECT_EQ(hand_over(), (Ids{0x300, 0x301}));
    EXPECT_EQ(hand_over(), Ids{});
    confirm_all();
    EXPECT_EQ(hand_over(), Ids{0x400});
}

TEST_F(CanTransmitterTest, SendsASnapshotWholeBeforeAnotherLaneHasItsTurn) {
    offer(1, snapshot(0x400, 2));
    EXPECT_EQ(hand_over(), Ids{0x400});
    offer(0, snapshot(0x300, 1));
    confirm_all();
    EXPECT_EQ(hand_over(), Ids{0x401});
    confirm_all();
    EXPECT_EQ(hand_over(), Ids{0x300});
}

TEST_F(CanTransmitterTest, ServesLanesInTurnHoweverOftenOneOffers) {
    Ids order;
    for (int turn = 0; turn < 4; ++turn) {
        offer(0, snapshot(0x300, 1));
        offer(5, snapshot(0x400, 1));
        order.push_back(hand_over().at(0));
        confirm_all();
    }
    EXPECT_EQ(order, (Ids{0x300, 0x400, 0x300, 0x400}));
}

TEST_F(CanTransmitterTest, ALaneWhoseSnapshotTookTooLongDoesNotBeginAgainBeforeTheOthers) {
    offer(0, snapshot(0x300, 3));
    hand_over();
    now_ += CanTransmitter::kMostWait - 1ms;
    confirm_all();
    hand_over(1);
    now_ += 1ms;
    transmitter_.poll(now_);
    ASSERT_EQ(counts_.abandoned, 1U);
    confirm_all();
    offer(0, snapshot(0x300, 3));
    offer(1, snapshot(0x400, 1));
    EXPECT_EQ(hand_over(), Ids{0x400});
}

TEST_F(CanTransmitterTest, IsBusyForALaneWhoseSnapshotHasBegun) {
    offer(0, snapshot(0x300, 2));
    hand_over();
    EXPECT_EQ(offer(0, snapshot(0x300, 2)), WriteStatus::busy);
    EXPECT_EQ(offer(1, snapshot(0x400, 2)), WriteStatus::written);
}

TEST_F(CanTransmitterTest, ANewerSnapshotReplacesOneThatHasNotBegun) {
    offer(1, snapshot(0x400, 1));
    hand_over();
    offer(0, snapshot(0x300, 1, 1));
    EXPECT_EQ(offer(0, snapshot(0x300, 1, 2)), WriteStatus::written);
    confirm_all();
    ASSERT_FALSE(transmitter_.next(now_).empty());
    EXPECT_EQ(transmitter_.next(now_)[0].data[0], 2);
    EXPECT_EQ(counts_.abandoned, 1U);
}

TEST_F(CanTransmitterTest, TakesTheNextSnapshotWhileTheLastFrameIsInFlight) {
    offer(0, snapshot(0x300, 1));
    hand_over();
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::written);
    EXPECT_EQ(hand_over(), Ids{});
}

TEST_F(CanTransmitterTest, RefusesSnapshotsThatCannotBe) {
    EXPECT_DEBUG_DEATH(
        { EXPECT_EQ(offer(kMostLanes, snapshot(0x300, 1)), WriteStatus::unavailable); }, "");
    EXPECT_DEBUG_DEATH({ EXPECT_EQ(offer(0, {}), WriteStatus::unavailable); }, "");
    EXPECT_DEBUG_DEATH(
        {
            EXPECT_EQ(offer(0, snapshot(0x300, kMostSnapshotFrames + 1)), WriteStatus::unavailable);
        },
        "");
}

TEST_F(CanTransmitterTest, EachFrameThatLeavesGivesTheOthersTheUsualTime) {
    prove_bus();
    offer(0, snapshot(0x300, 3));
    hand_over();
    for (int frame = 0; frame < 2; ++frame) {
        now_ += CanTransmitter::kMostWait - 1ms;
        confirm();
    }
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    now_ += CanTransmitter::kMostWait;
    transmitter_.poll(now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::stalled);
}

TEST_F(CanTransmitterTest, AFrameThatLeavesEndsAStallAndTheNextSnapshotWaitsForTheOthers) {
    prove_bus();
    offer(0, snapshot(0x300, 2));
    hand_over();
    const std::vector<CanFrame> held = controller_;
    now_ += CanTransmitter::kMostWait;
    transmitter_.poll(now_);
    transmitter_.confirmed(held[0], now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    EXPECT_EQ(offer(0, snapshot(0x400, 2)), WriteStatus::written);
    EXPECT_EQ(hand_over(), Ids{});
    transmitter_.confirmed(held[1], now_);
    EXPECT_EQ(hand_over(), (Ids{0x400, 0x401}));
}

TEST_F(CanTransmitterTest, AFrameThatDoesNotLeaveIsAStallAndTheRestOfAllLanesIsAbandoned) {
    offer(0, snapshot(0x300, 3));
    offer(1, snapshot(0x400, 1));
    hand_over();
    EXPECT_EQ(transmitter_.due(), now_ + CanTransmitter::kMostWait);
    now_ += CanTransmitter::kMostWait - 1ns;
    transmitter_.poll(now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    now_ += 1ns;
    transmitter_.poll(now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::stalled);
    EXPECT_EQ(counts_.stalls, 1U);
    EXPECT_EQ(counts_.abandoned, 2U);
    EXPECT_EQ(transmitter_.due(), kNever);
}

TEST_F(CanTransmitterTest, WhileStalledItTakesNothing) {
    stall();
    now_ += 1h;
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::unavailable);
    EXPECT_EQ(hand_over(), Ids{});
    EXPECT_TRUE(transmitter_.in_flight());
}

TEST_F(CanTransmitterTest, AStallEndsWhenTheFrameHasLeftAtLastAndTheNextOfferGoes) {
    stall();
    now_ += 5s;
    confirm_all();
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    EXPECT_EQ(hand_over(), Ids{}) << "nothing offered before may be left";
    offer(0, snapshot(0x300, 1));
    EXPECT_EQ(hand_over(), Ids{0x300});
    EXPECT_EQ(counts_.stalls, 1U);
}

TEST_F(CanTransmitterTest, ASnapshotIsAbandonedWhenItIsTooOldAlthoughItsFramesMove) {
    offer(0, snapshot(0x300, 4));
    for (int sent = 0; sent < 2; ++sent) {
        hand_over(1);
        now_ += 25ms;
        confirm_all();
    }
    EXPECT_EQ(hand_over(), Ids{});
    EXPECT_EQ(counts_.abandoned, 1U);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
}

TEST_F(CanTransmitterTest, AFullQueueIsTriedAgainByTimer) {
    offer(0, snapshot(0x300, 1));
    ASSERT_FALSE(transmitter_.next(now_).empty());
    transmitter_.refused_full(now_);
    EXPECT_TRUE(transmitter_.next(now_).empty());
    EXPECT_EQ(transmitter_.due(), now_ + CanTransmitter::kFullRetry);
    now_ += CanTransmitter::kFullRetry;
    EXPECT_EQ(hand_over(), Ids{0x300});
    EXPECT_EQ(counts_.queue_full, 1U);
}

TEST_F(CanTransmitterTest, AQueueThatStaysFullIsAStallThatEachOfferTries) {
    offer(0, snapshot(0x300, 1));
    for (Duration spent = 0ms; spent < CanTransmitter::kMostWait; spent += 1ms) {
        ASSERT_FALSE(transmitter_.next(now_).empty());
        transmitter_.refused_full(now_);
        now_ += 1ms;
    }
    EXPECT_TRUE(transmitter_.next(now_).empty());
    EXPECT_EQ(transmitter_.state(), CanBusState::stalled);
    EXPECT_EQ(counts_.stalls, 1U);

    offer(0, snapshot(0x300, 1));
    ASSERT_FALSE(transmitter_.next(now_).empty());
    transmitter_.refused_full(now_);
    now_ += 1ms;
    EXPECT_TRUE(transmitter_.next(now_).empty()) << "refused again: not kept for later";

    offer(0, snapshot(0x300, 1));
    EXPECT_EQ(hand_over(), Ids{0x300});
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    EXPECT_EQ(counts_.stalls, 1U);
}

TEST_F(CanTransmitterTest, AFrameThatTheKernelNeverTakesEndsItsSnapshotAndNoOther) {
    offer(0, snapshot(0x300, 2));
    offer(1, snapshot(0x400, 1));
    ASSERT_FALSE(transmitter_.next(now_).empty());
    transmitter_.refused();
    EXPECT_EQ(hand_over(), Ids{0x400});
    EXPECT_EQ(counts_.abandoned, 1U);
}

TEST_F(CanTransmitterTest, GoingDownDropsAllAndForgetsTheFrameInFlight) {
    offer(0, snapshot(0x300, 2));
    hand_over();
    transmitter_.went_down();
    EXPECT_EQ(transmitter_.state(), CanBusState::down);
    EXPECT_FALSE(transmitter_.in_flight());
    EXPECT_EQ(offer(0, snapshot(0x300, 2)), WriteStatus::unavailable);
    EXPECT_EQ(hand_over(), Ids{});
    EXPECT_EQ(counts_.downs, 1U);
    EXPECT_EQ(counts_.abandoned, 1U);
}

TEST_F(CanTransmitterTest, AfterComingUpItSendsWhatIsOfferedThenOnceTheQueueIsThere) {
    transmitter_.went_down();
    transmitter_.went_down();
    EXPECT_EQ(counts_.downs, 1U);
    transmitter_.came_up(now_);
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::written);
    EXPECT_EQ(hand_over(), Ids{});
    EXPECT_EQ(transmitter_.due(), now_ + CanTransmitter::kSettlingTime);
    settle();
    EXPECT_EQ(hand_over(), Ids{0x300});
}

TEST_F(CanTransmitterTest, BusOffAbandonsAllAndRefusesOffersUntilTheProbe) {
    offer(0, snapshot(0x300, 2));
    transmitter_.bus_off(now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::bus_off);
    EXPECT_EQ(counts_.bus_offs, 1U);
    EXPECT_EQ(counts_.abandoned, 1U);
    now_ += CanTransmitter::kProbePeriod - 1ns;
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::unavailable);
    EXPECT_EQ(hand_over(), Ids{});
    now_ += 1ns;
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::written);
    EXPECT_EQ(offer(1, snapshot(0x400, 1)), WriteStatus::unavailable) << "one probe";
    EXPECT_EQ(hand_over(), Ids{0x300});
    confirm_all();
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
}

TEST_F(CanTransmitterTest, AFrameThatTheControllerHeldAtBusOffIsTheProbe) {
    offer(0, snapshot(0x300, 1));
    hand_over();
    transmitter_.bus_off(now_);
    now_ += 1h;
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::unavailable);
    EXPECT_EQ(transmitter_.state(), CanBusState::bus_off);
    confirm_all();
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    EXPECT_EQ(counts_.stalls, 0U);
}

TEST_F(CanTransmitterTest, ARestartedControllerHoldsNothing) {
    offer(0, snapshot(0x300, 1));
    hand_over();
    transmitter_.bus_off(now_);
    transmitter_.restarted(now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    EXPECT_FALSE(transmitter_.in_flight());
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::written);
    settle();
    EXPECT_EQ(hand_over(), Ids{0x300});
}

TEST_F(CanTransmitterTest, AfterASignOfLifeTheFrameHeldAtBusOffHasTheUsualTimeToShow) {
    offer(0, snapshot(0x100, 1));
    hand_over();
    transmitter_.bus_off(now_);
    now_ += 10s;
    transmitter_.alive(now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    offer(0, snapshot(0x300, 1));
    EXPECT_EQ(hand_over(), Ids{});
    now_ += CanTransmitter::kMostWait;
    offer(0, snapshot(0x300, 1));
    EXPECT_EQ(hand_over(), Ids{0x300});
    EXPECT_EQ(counts_.stalls, 0U);
}

TEST_F(CanTransmitterTest, ASignOfLifeOutsideOfBusOffDoesNotProlongAStall) {
    offer(0, snapshot(0x300, 1));
    hand_over();
    now_ += CanTransmitter::kMostWait - 1ms;
    transmitter_.alive(now_);
    now_ += 1ms;
    transmitter_.poll(now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::stalled);
}

TEST_F(CanTransmitterTest, ALostConfirmationEndsAStallWithoutBeingCountedAsOne) {
    stall();
    transmitter_.forget_flight();
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    EXPECT_EQ(counts_.confirmed, 0U);
}

TEST_F(CanTransmitterTest, ConfirmationsOfUnknownFramesChangeNothing) {
    offer(0, snapshot(0x300, 2));
    transmitter_.confirmed(frame(0x300), now_);
    transmitter_.confirmed_all();
    EXPECT_EQ(counts_.confirmed, 0U);
    hand_over();
    transmitter_.confirmed(frame(0x300, 1), now_);
    transmitter_.confirmed(frame(0x301), now_);
    EXPECT_EQ(counts_.confirmed, 0U);
    EXPECT_TRUE(transmitter_.in_flight());
}

TEST_F(CanTransmitterTest, ErrorLevelsAreShownButDoNotHinder) {
    transmitter_.error_level(CanTransmitter::ErrorLevel::passive);
    EXPECT_EQ(transmitter_.state(), CanBusState::passive);
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::written);
    transmitter_.error_level(CanTransmitter::ErrorLevel::warning);
    EXPECT_EQ(transmitter_.state(), CanBusState::warning);
    transmitter_.error_level(CanTransmitter::ErrorLevel::active);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
}

}  // namespace
}  // namespace tribus::can_transmitter_test
