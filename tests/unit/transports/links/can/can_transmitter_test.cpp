#include "transports/links/can/can_transmitter.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
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

class CanTransmitterTest : public ::testing::Test {
  protected:
    WriteStatus offer(std::size_t lane, const std::vector<CanFrame>& frames) {
        return transmitter_.offer(lane, frames, now_);
    }
    /// Returns the id of the frame that is passed to the kernel now.
    std::optional<std::uint32_t> hand_over() {
        const CanFrame* next = transmitter_.next(now_);
        if (next == nullptr) {
            return std::nullopt;
        }
        const std::uint32_t id = next->id;
        transmitter_.handed(now_);
        return id;
    }
    void stall() {
        offer(0, snapshot(0x100, 1));
        hand_over();
        now_ += CanTransmitter::kMostWait;
        transmitter_.poll(now_);
    }
    void settle() { now_ += CanTransmitter::kSettlingTime; }

    CanCounts counts_;
    CanTransmitter transmitter_{counts_};
    Instant now_ = Instant(1h);
};

TEST_F(CanTransmitterTest, HandsOverNothingBeforeAnOffer) {
    EXPECT_EQ(transmitter_.next(now_), nullptr);
    EXPECT_EQ(transmitter_.due(), kNever);
}

TEST_F(CanTransmitterTest, HandsOverTheNextFrameOnlyAfterTheOneBeforeIsConfirmed) {
    EXPECT_EQ(offer(0, snapshot(0x300, 2)), WriteStatus::written);
    EXPECT_EQ(hand_over(), 0x300U);
    EXPECT_EQ(hand_over(), std::nullopt);
    transmitter_.confirmed();
    EXPECT_EQ(hand_over(), 0x301U);
    transmitter_.confirmed();
    EXPECT_EQ(hand_over(), std::nullopt);
    EXPECT_EQ(counts_.sent, 2U);
    EXPECT_EQ(counts_.confirmed, 2U);
}

TEST_F(CanTransmitterTest, OneFrameIsInFlightOverAllLanes) {
    offer(0, snapshot(0x300, 1));
    offer(1, snapshot(0x400, 1));
    EXPECT_EQ(hand_over(), 0x300U);
    EXPECT_EQ(hand_over(), std::nullopt);
    transmitter_.confirmed();
    EXPECT_EQ(hand_over(), 0x400U);
}

TEST_F(CanTransmitterTest, SendsASnapshotWholeBeforeAnotherLaneHasItsTurn) {
    offer(1, snapshot(0x400, 2));
    EXPECT_EQ(hand_over(), 0x400U);
    offer(0, snapshot(0x300, 1));
    transmitter_.confirmed();
    EXPECT_EQ(hand_over(), 0x401U);
    transmitter_.confirmed();
    EXPECT_EQ(hand_over(), 0x300U);
}

TEST_F(CanTransmitterTest, ServesLanesInTurnHoweverOftenOneOffers) {
    std::vector<std::uint32_t> order;
    for (int turn = 0; turn < 4; ++turn) {
        offer(0, snapshot(0x300, 1));
        offer(5, snapshot(0x400, 1));
        order.push_back(hand_over().value_or(0));
        transmitter_.confirmed();
    }
    EXPECT_EQ(order, (std::vector<std::uint32_t>{0x300, 0x400, 0x300, 0x400}));
}

TEST_F(CanTransmitterTest, ALaneWhoseSnapshotTookTooLongDoesNotBeginAgainBeforeTheOthers) {
    offer(0, snapshot(0x300, 3));
    hand_over();
    now_ += CanTransmitter::kMostWait - 1ms;
    transmitter_.confirmed();
    hand_over();
    now_ += 1ms;
    transmitter_.poll(now_);
    ASSERT_EQ(counts_.abandoned, 1U);
    transmitter_.confirmed();
    offer(0, snapshot(0x300, 3));
    offer(1, snapshot(0x400, 1));
    EXPECT_EQ(hand_over(), 0x400U);
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
    transmitter_.confirmed();
    ASSERT_NE(transmitter_.next(now_), nullptr);
    EXPECT_EQ(transmitter_.next(now_)->data[0], 2);
    EXPECT_EQ(counts_.abandoned, 1U);
}

TEST_F(CanTransmitterTest, TakesTheNextSnapshotWhileTheLastFrameIsInFlight) {
    offer(0, snapshot(0x300, 1));
    hand_over();
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::written);
    EXPECT_EQ(hand_over(), std::nullopt);
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

TEST_F(CanTransmitterTest, WhileStalledItTakesNothingAndKnowsTheFrameInFlight) {
    stall();
    now_ += 1h;
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::unavailable);
    EXPECT_EQ(hand_over(), std::nullopt);
    ASSERT_NE(transmitter_.in_flight(), nullptr);
    EXPECT_EQ(transmitter_.in_flight()->id, 0x100U);
}

TEST_F(CanTransmitterTest, AStallEndsWhenTheFrameHasLeftAtLastAndTheNextOfferGoes) {
    stall();
    now_ += 5s;
    transmitter_.confirmed();
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    EXPECT_EQ(hand_over(), std::nullopt) << "nothing offered before may be left";
    offer(0, snapshot(0x300, 1));
    EXPECT_EQ(hand_over(), 0x300U);
    EXPECT_EQ(counts_.stalls, 1U);
}

TEST_F(CanTransmitterTest, ASnapshotIsAbandonedWhenItIsTooOldAlthoughItsFramesMove) {
    offer(0, snapshot(0x300, 4));
    for (int sent = 0; sent < 2; ++sent) {
        hand_over();
        now_ += 25ms;
        transmitter_.confirmed();
    }
    EXPECT_EQ(hand_over(), std::nullopt);
    EXPECT_EQ(counts_.abandoned, 1U);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
}

TEST_F(CanTransmitterTest, AFullQueueIsTriedAgainByTimer) {
    offer(0, snapshot(0x300, 1));
    ASSERT_NE(transmitter_.next(now_), nullptr);
    transmitter_.refused_full(now_);
    EXPECT_EQ(transmitter_.next(now_), nullptr);
    EXPECT_EQ(transmitter_.due(), now_ + CanTransmitter::kFullRetry);
    now_ += CanTransmitter::kFullRetry;
    EXPECT_EQ(hand_over(), 0x300U);
    EXPECT_EQ(counts_.queue_full, 1U);
}

TEST_F(CanTransmitterTest, AQueueThatStaysFullIsAStallThatEachOfferTries) {
    offer(0, snapshot(0x300, 1));
    for (Duration spent = 0ms; spent < CanTransmitter::kMostWait; spent += 1ms) {
        ASSERT_NE(transmitter_.next(now_), nullptr);
        transmitter_.refused_full(now_);
        now_ += 1ms;
    }
    EXPECT_EQ(transmitter_.next(now_), nullptr);
    EXPECT_EQ(transmitter_.state(), CanBusState::stalled);
    EXPECT_EQ(counts_.stalls, 1U);

    offer(0, snapshot(0x300, 1));
    ASSERT_NE(transmitter_.next(now_), nullptr);
    transmitter_.refused_full(now_);
    now_ += 1ms;
    EXPECT_EQ(transmitter_.next(now_), nullptr) << "refused again: not kept for later";

    offer(0, snapshot(0x300, 1));
    EXPECT_EQ(hand_over(), 0x300U);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    EXPECT_EQ(counts_.stalls, 1U);
}

TEST_F(CanTransmitterTest, AFrameThatTheKernelNeverTakesEndsItsSnapshotAndNoOther) {
    offer(0, snapshot(0x300, 2));
    offer(1, snapshot(0x400, 1));
    ASSERT_NE(transmitter_.next(now_), nullptr);
    transmitter_.refused();
    EXPECT_EQ(hand_over(), 0x400U);
    EXPECT_EQ(counts_.abandoned, 1U);
}

TEST_F(CanTransmitterTest, GoingDownDropsAllAndForgetsTheFrameInFlight) {
    offer(0, snapshot(0x300, 2));
    hand_over();
    transmitter_.went_down();
    EXPECT_EQ(transmitter_.state(), CanBusState::down);
    EXPECT_EQ(transmitter_.in_flight(), nullptr);
    EXPECT_EQ(offer(0, snapshot(0x300, 2)), WriteStatus::unavailable);
    EXPECT_EQ(hand_over(), std::nullopt);
    EXPECT_EQ(counts_.downs, 1U);
    EXPECT_EQ(counts_.abandoned, 1U);
}

TEST_F(CanTransmitterTest, AfterComingUpItSendsWhatIsOfferedThenOnceTheQueueIsThere) {
    transmitter_.went_down();
    transmitter_.went_down();
    EXPECT_EQ(counts_.downs, 1U);
    transmitter_.came_up(now_);
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::written);
    EXPECT_EQ(hand_over(), std::nullopt);
    EXPECT_EQ(transmitter_.due(), now_ + CanTransmitter::kSettlingTime);
    settle();
    EXPECT_EQ(hand_over(), 0x300U);
}

TEST_F(CanTransmitterTest, BusOffAbandonsAllAndRefusesOffersUntilTheProbe) {
    offer(0, snapshot(0x300, 2));
    transmitter_.bus_off(now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::bus_off);
    EXPECT_EQ(counts_.bus_offs, 1U);
    EXPECT_EQ(counts_.abandoned, 1U);
    now_ += CanTransmitter::kProbePeriod - 1ns;
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::unavailable);
    EXPECT_EQ(hand_over(), std::nullopt);
    now_ += 1ns;
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::written);
    EXPECT_EQ(offer(1, snapshot(0x400, 1)), WriteStatus::unavailable) << "one probe";
    EXPECT_EQ(hand_over(), 0x300U);
    transmitter_.confirmed();
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
}

TEST_F(CanTransmitterTest, AFrameThatTheControllerHeldAtBusOffIsTheProbe) {
    offer(0, snapshot(0x300, 1));
    hand_over();
    transmitter_.bus_off(now_);
    now_ += 1h;
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::unavailable);
    EXPECT_EQ(transmitter_.state(), CanBusState::bus_off);
    transmitter_.confirmed();
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    EXPECT_EQ(counts_.stalls, 0U);
}

TEST_F(CanTransmitterTest, ARestartedControllerHoldsNothing) {
    offer(0, snapshot(0x300, 1));
    hand_over();
    transmitter_.bus_off(now_);
    transmitter_.restarted(now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    EXPECT_EQ(transmitter_.in_flight(), nullptr);
    EXPECT_EQ(offer(0, snapshot(0x300, 1)), WriteStatus::written);
    settle();
    EXPECT_EQ(hand_over(), 0x300U);
}

TEST_F(CanTransmitterTest, AfterASignOfLifeTheFrameHeldAtBusOffHasTheUsualTimeToShow) {
    offer(0, snapshot(0x100, 1));
    hand_over();
    transmitter_.bus_off(now_);
    now_ += 10s;
    transmitter_.alive(now_);
    EXPECT_EQ(transmitter_.state(), CanBusState::ready);
    offer(0, snapshot(0x300, 1));
    EXPECT_EQ(hand_over(), std::nullopt);
    now_ += CanTransmitter::kMostWait;
    offer(0, snapshot(0x300, 1));
    EXPECT_EQ(hand_over(), 0x300U);
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
    transmitter_.confirmed();
    EXPECT_EQ(counts_.confirmed, 0U);
    EXPECT_EQ(hand_over(), 0x300U);
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
