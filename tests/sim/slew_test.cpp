#include <gtest/gtest.h>

#include <cstdint>
#include <optional>

#include "tests/sim/simulation.h"
#include "tests/sim/slewing_world.h"

/// No channel with a limit of its rate of change ever moves faster between two frames that an
/// output wrote.
namespace tribus::test::slew_test {
namespace {

void expect_no_larger_step(std::uint64_t seeds) {
    for_each_seed(seeds, [](std::uint64_t seed) {
        EXPECT_EQ(SlewingWorld(seed).too_large_step(), std::nullopt);
    });
}

TEST(Slew, IsKeptInRandomWorldsWithLossesReloadsAndStalls) {
    expect_no_larger_step(100);
}

TEST(SlewInManyWorlds, IsKeptWithLossesReloadsAndStalls) {
    expect_no_larger_step(2000);
}

}  // namespace
}  // namespace tribus::test::slew_test
