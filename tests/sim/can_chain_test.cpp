#include "tests/sim/can_chain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ostream>
#include <string>

#include <fmt/format.h>

#include "tests/sim/stored_table.h"
#include "tests/support/sanitized.h"

namespace tribus::test::can_chain_test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kSeeds = 24;
constexpr Instant kInputEnds = Instant(10s);
constexpr Instant kEnd = Instant(12s);
constexpr Duration kTimeout = 100ms;
constexpr Duration kHold = 300ms;
constexpr Duration kRecover = 500ms;
constexpr Duration kMostDelay = 5ms;
/// Longest time from the first frame of a snapshot at A to its last one at B.
constexpr Duration kMostBusTime = 5 * kCanFrameTime + kMostDelay;
/// Age of the oldest values that A sends unmarked. They count until A's next frame.
constexpr Duration kOldestSent = kTimeout - kChainPeriod;

struct Format {
    const char* name;
    const char* lines;
    /// Largest part of the age, besides the time on the bus, that the format does not tell B.
    Duration untold_age;
    const char* protocol = "can";
    const char* sender_lines = "";
    /// Whether the format finds flipped bits itself. CAN finds nearly all of them.
    bool finds_flipped_bits = true;
};
/// Classic frames tell ages to the nearest 0.25 ms up to 63.5 ms, FD frames to the nearest 0.01 ms,
/// the other formats not at all.
constexpr Duration kUntoldByClassic = kOldestSent - 63'500us + 125us;
constexpr std::array kFormats{
    Format{"classic, P22", "", kUntoldByClassic},
    Format{"classic, P01", "crc = \"p01\"", kUntoldByClassic},
    Format{"classic, 16 channels", "channels = 16", kOldestSent},
    Format{"FD", "fd = true", 5us},
    Format{"DroneCAN", "", kOldestSent, "dronecan", "node_id = 42\nforce = true", false},
    Format{"DroneCAN FD", "fd = true", kOldestSent, "dronecan", "node_id = 42\nforce = true",
           false},
};

std::ostream& operator<<(std::ostream& out, const Format& format) {
    return out << format.name;
}

/// Each seed has its own mix: some buses are clean, on some every tenth frame has a fault.
CanFaultSettings nasty(std::uint64_t seed, const Format& format) {
    const auto level = [&](unsigned divisor, unsigned steps) {
        return 0.1 * static_cast<double>(seed / divisor % steps) / steps;
    };
    return {.lose_frame = level(1, 3),
            .duplicate_frame = level(2, 5),
            .flip_bit = format.finds_flipped_bits ? level(3, 4) : 0,
            .late_frame = level(5, 2),
            .most_delay = kMostDelay};
}

class CanChainTest : public testing::TestWithParam<Format> {
  protected:
    template <class Check>
    void for_all_seeds(Check check) {
        for_each_seed(kSeeds, [&](std::uint64_t seed) {
            check(CanChain({.protocol = GetParam().protocol,
                            .format = GetParam().lines,
                            .sender_lines = GetParam().sender_lines,
                            .faults = nasty(seed, GetParam()),
                            .input_ends = kInputEnds,
                            .end = kEnd,
                            .seed = seed}));
        });
    }
    static CanChain interrupted(double loss) {
        return CanChain({.protocol = GetParam().protocol,
                         .format = GetParam().lines,
                         .sender_lines = GetParam().sender_lines,
                         .faults = {.lose_frame = loss},
                         .input_ends = kEnd,
                         .end = kEnd,
                         .bus_dies = kBusDies,
                         .bus_returns = kBusReturns});
    }
    static constexpr Instant kBusDies = Instant(4s);
    static constexpr Instant kBusReturns = Instant(8s);
};

INSTANTIATE_TEST_SUITE_P(Formats, CanChainTest, testing::ValuesIn(kFormats));

/// Returns when the first frame from `from` on was written for which `says` is true.
template <class Says>
Instant first_that(const CanChain& chain, Instant from, Says says) {
    const auto& written = chain.b().written();
    const auto found = std::ranges::find_if(
        written, [&](const Written& frame) { return frame.at >= from && says(frame.frame); });
    return found == written.end() ? kNever : found->at;
}

TEST_P(CanChainTest, WhatIsWrittenAsGoodIsOneWholeSnapshotThatTheSenderWasGiven) {
    for_all_seeds([](const CanChain& chain) {
        std::size_t good = 0;
        for (const Written& written : chain.b().written()) {
            if (!written.frame.failsafe) {
                ASSERT_TRUE(whole(written)) << "at " << written.at.time_since_epoch().count();
                ASSERT_TRUE(chain.a().arrived_at(0, *written.number));
                good += written.frame.good() ? 1U : 0U;
            }
        }
        ASSERT_GT(good, 100U);
    });
}

TEST_P(CanChainTest, NoFrameCarriesOlderValuesThanTheOneBefore) {
    for_all_seeds([](const CanChain& chain) {
        std::uint32_t latest = 0;
        for (const Written& written : chain.b().written()) {
            if (!written.frame.failsafe) {
                ASSERT_GE(*written.number, latest);
                latest = *written.number;
            }
        }
    });
}

TEST_P(CanChainTest, GoodValuesAreNotOlderThanTheTimeoutsAllowUntilTheNextFrame) {
    // If the format tells the age, the waiting at A counts at B, so the two timeouts do not add up.
    // No format can tell the time on the bus.
    const Duration allowed = kTimeout + GetParam().untold_age + kMostBusTime;
    for_all_seeds([&](const CanChain& chain) {
        for (const Written& written : chain.b().written()) {
            if (written.frame.good()) {
                ASSERT_LE(chain.age(written) + kChainPeriod, allowed);
            }
        }
    });
}

TEST_P(CanChainTest, TheEndOfTheInputEndsInFailsafeThroughTheBus) {
    const Duration most_lost = kTimeout + GetParam().untold_age + kMostBusTime;
    for_all_seeds([&](const CanChain& chain) {
        const Instant last_input = chain.a().engine().inputs()[0].control().received;
        const Instant failsafe =
            first_that(chain, last_input, [](const ChannelFrame& frame) { return frame.failsafe; });
        EXPECT_LE(failsafe - last_input, most_lost + kHold);
        for (const Written& written : chain.b().written()) {
            ASSERT_TRUE(written.at < failsafe || written.frame.failsafe);
        }
    });
}

TEST_P(CanChainTest, TheLossOfTheBusIsMarkedWithinTheTimeoutThenFailsafe) {
    for (const double loss : {0.0, 0.05}) {
        const CanChain chain = interrupted(loss);
        const Instant lost =
            first_that(chain, kBusDies, [](const ChannelFrame& frame) { return frame.frame_lost; });
        const Instant failsafe =
            first_that(chain, kBusDies, [](const ChannelFrame& frame) { return frame.failsafe; });
        EXPECT_LE(lost - kBusDies, kTimeout);
        EXPECT_LE(failsafe - kBusDies, kTimeout + kHold);
        if (loss == 0) {
            // The last values are already as old as i.Bus, A's period and the bus make them.
            EXPECT_GE(lost - kBusDies, kTimeout - 4 * kChainPeriod);
            EXPECT_GE(failsafe - kBusDies, kTimeout + kHold - 4 * kChainPeriod);
        }
    }
}

TEST_P(CanChainTest, TheReturnOfTheBusGivesControlBackAfterRecover) {
    for (const double loss : {0.0, 0.05}) {
        const CanChain chain = interrupted(loss);
        const Instant good =
            first_that(chain, kBusReturns, [](const ChannelFrame& frame) { return frame.good(); });
        EXPECT_GE(good - kBusReturns, kRecover);
        // Three snapshots prove the sender, and some of them may be lost.
        EXPECT_LE(good - kBusReturns, kRecover + (loss == 0 ? 5 : 25) * kChainPeriod);
    }
}

TEST_P(CanChainTest, ACleanBusLosesNoSnapshotButTheTwoOfTheProof) {
    const CanChain chain({.protocol = GetParam().protocol,
                          .format = GetParam().lines,
                          .sender_lines = GetParam().sender_lines,
                          .input_ends = kEnd,
                          .end = kEnd});
    EXPECT_GE(chain.snapshots_published() + 3, chain.snapshots_sent());
}

TEST_P(CanChainTest, AllocatesNothingAfterStart) {
    if (kSanitized) {
        GTEST_SKIP() << "a sanitizer has its own malloc";
    }
    for_all_seeds([](const CanChain& chain) {
        EXPECT_EQ(chain.a().allocations(), 0U);
        EXPECT_EQ(chain.b().allocations(), 0U);
    });
}

std::string row(const Format& format, double loss) {
    const CanChain chain({.protocol = format.protocol,
                          .format = format.lines,
                          .sender_lines = format.sender_lines,
                          .faults = {.lose_frame = loss},
                          .input_ends = Instant(30s),
                          .end = Instant(30s),
                          .seed = 2026});
    Duration oldest{};
    std::size_t good = 0;
    for (const Written& written : chain.b().written()) {
        if (written.frame.good()) {
            oldest = std::max(oldest, chain.age(written));
            ++good;
        }
    }
    const double published = 100.0 * static_cast<double>(chain.snapshots_published()) /
                             static_cast<double>(chain.snapshots_sent());
    return fmt::format(
        "{:<22}{:5.0f} {:12.1f} {:8.1f} {:10.1f}\n", format.name, 100 * loss, published,
        100.0 * static_cast<double>(good) / static_cast<double>(chain.b().written().size()),
        std::chrono::duration<double, std::milli>(oldest).count());
}

TEST(CanBehaviour, LossAndFormatToPublishedSnapshotsAndAgeAreAsStored) {
    std::string now =
        "# i.Bus -> A -> CAN that loses single frames -> B -> SBUS, 30 s, a snapshot each 7.7 ms.\n"
        "# Shares of the snapshots that A sent and B published, and of B's frames that are under\n"
        "# control; the oldest values in those, from their arrival at A (timeout 100 ms).\n"
        "format                loss%  published%    good%  oldest ms\n";
    for (const Format& format : kFormats) {
        for (const double loss : {0.0, 0.01, 0.05, 0.2, 0.4}) {
            now += row(format, loss);
        }
    }
    expect_stored("can_behaviour.txt", now);
}

}  // namespace
}  // namespace tribus::test::can_chain_test
