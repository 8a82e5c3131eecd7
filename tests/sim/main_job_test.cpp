#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "tests/sim/simulation.h"
#include "tests/support/heap_trap.h"
#include "tests/support/sanitized.h"

namespace tribus::test::main_job_test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kSeeds = 40;
constexpr Instant kInputEnds = Instant(20s);
constexpr Instant kEnd = Instant(22s);
constexpr Duration kPeriod = 7ms;
/// SBUS has it shorter than the period.
constexpr Duration kLeastSpacing = 6ms;
constexpr Duration kTimeout = 100ms;
constexpr Duration kHold = 300ms;

/// Each seed has its own mix: some wires are clean, some lose every fifth frame. There are no
/// flipped bits: two of them can cancel in the checksum of i.Bus, which is a sum, and no reader can
/// notice.
FaultSettings nasty(std::uint64_t seed) {
    const auto level = [&](unsigned divisor, unsigned steps) {
        return static_cast<double>(seed / divisor % steps) / steps;
    };
    return {.lose_byte = 0.01 * level(1, 3),
            .add_byte = 0.01 * level(3, 5),
            .damage_byte = 0.01 * level(5, 3),
            .drop_frame = 0.2 * level(7, 4),
            .most_delay = std::chrono::milliseconds(seed % 5)};
}

class MainJob : public testing::Test {
  protected:
    Simulation simulate(std::uint64_t seed, Duration input_period) {
        Sender sender{.period = input_period, .last = kInputEnds, .faults = nasty(seed)};
        Simulation simulation(configuration_of(main_job()), {sender}, seed);
        simulation.run_until(kEnd);
        return simulation;
    }
    template <class Check>
    void for_all_seeds(Check check) {
        for_each_seed(kSeeds, [&](std::uint64_t seed) {
            check(simulate(seed, seed % 2 == 0 ? 7700us : 4ms));
        });
    }
};

TEST_F(MainJob, NeverWritesTwoFramesCloserThanReadersTakeNorThreeWithinAPeriod) {
    for_all_seeds([](const Simulation& simulation) {
        const auto& written = simulation.written();
        ASSERT_GT(written.size(), 1000U);
        for (std::size_t i = 2; i < written.size(); ++i) {
            ASSERT_GE(written[i].at - written[i - 1].at, kLeastSpacing) << "frame " << i;
            ASSERT_GE(written[i].at - written[i - 2].at, 2 * kLeastSpacing) << "frame " << i;
        }
    });
}

TEST_F(MainJob, WritesAtMostOneFrameAPeriodOverAnyTime) {
    for_all_seeds([](const Simulation& simulation) {
        const auto& written = simulation.written();
        for (const std::size_t frames : {10U, 100U, 1000U}) {
            for (std::size_t i = frames; i < written.size(); ++i) {
                ASSERT_GE(written[i].at - written[i - frames].at, (frames - 1) * kPeriod);
            }
        }
    });
}

TEST_F(MainJob, NeverPausesLongerThanTwoPeriodsAndATick) {
    for_all_seeds([](const Simulation& simulation) {
        const auto& written = simulation.written();
        for (std::size_t i = 1; i < written.size(); ++i) {
            ASSERT_LE(written[i].at - written[i - 1].at, 2 * kPeriod + 4500us) << "frame " << i;
        }
    });
}

TEST_F(MainJob, FramesInControlCarryAFrameThatWasSentAndNoOlderOneThanBefore) {
    for_all_seeds([](const Simulation& simulation) {
        std::uint32_t latest = 0;
        for (const Written& written : simulation.written()) {
            if (written.frame.failsafe) {
                continue;
            }
            ASSERT_TRUE(written.number);
            ASSERT_TRUE(simulation.arrived_at(0, *written.number));
            ASSERT_GE(*written.number, latest);
            latest = *written.number;
        }
    });
}

TEST_F(MainJob, OnACleanWireEveryFrameCarriesTheNewestInput) {
    for (const Duration period : {Duration(4ms), Duration(7700us), Duration(20ms)}) {
        Simulation simulation(configuration_of(main_job()),
                              {Sender{.period = period, .last = kInputEnds, .faults = {}}}, 1);
        simulation.run_until(kInputEnds);
        for (const Written& written : simulation.written()) {
            if (!written.frame.good()) {
                continue;
            }
            const auto newer = simulation.arrived_at(0, *written.number + 1);
            ASSERT_TRUE(!newer || *newer > written.at)
                << "at " << written.at.time_since_epoch().count();
        }
    }
}

TEST_F(MainJob, UnmarkedValuesAreNeverOlderThanTheTimeoutUntilTheNextFrame) {
    for_all_seeds([](const Simulation& simulation) {
        const auto& written = simulation.written();
        for (std::size_t i = 0; i + 1 < written.size(); ++i) {
            if (written[i].frame.good()) {
                const auto arrived = simulation.arrived_at(0, *written[i].number);
                ASSERT_LE(written[i].at + kPeriod - *arrived, kTimeout) << "frame " << i;
            }
        }
    });
}

TEST_F(MainJob, AfterTheInputEndsItSaysFrameLostWithinTheTimeoutThenFailsafe) {
    for_all_seeds([](const Simulation& simulation) {
        const auto& written = simulation.written();
        const Instant last_good = simulation.engine().inputs()[0].control().received;
        const auto first_after = [&](auto says) {
            return std::find_if(written.begin(), written.end(), [&](const Written& frame) {
                return frame.at > last_good && says(frame.frame);
            });
        };
        const auto lost = first_after([](const ChannelFrame& f) { return f.frame_lost; });
        const auto failsafe = first_after([](const ChannelFrame& f) { return f.failsafe; });
        ASSERT_NE(lost, written.end());
        ASSERT_NE(failsafe, written.end());
        EXPECT_LE(lost->at - last_good, kTimeout);
        EXPECT_GE(lost->at - last_good, kTimeout - 2 * kPeriod);
        EXPECT_LE(failsafe->at - last_good, kTimeout + kHold);
        EXPECT_GE(failsafe->at - last_good, kTimeout + kHold - 2 * kPeriod);
        EXPECT_TRUE(std::all_of(failsafe, written.end(), [](const Written& frame) {
            return frame.frame.failsafe && frame.frame.frame_lost;
        }));
    });
}

TEST_F(MainJob, AllocatesNothingAfterStart) {
    if (kSanitized) {
        GTEST_SKIP() << "a sanitizer has its own malloc";
    }
    for_all_seeds([](const Simulation& simulation) { EXPECT_EQ(simulation.allocations(), 0U); });
}

TEST(HeapTrapTest, SeesAnAllocation) {
    if (kSanitized) {
        GTEST_SKIP() << "a sanitizer has its own malloc";
    }
    const HeapTrap trap;
    void* volatile block = std::malloc(1);
    std::free(block);
    EXPECT_EQ(trap.allocations(), 1U);
}

}  // namespace
}  // namespace tribus::test::main_job_test
