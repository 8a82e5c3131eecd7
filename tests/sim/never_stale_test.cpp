#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "tests/sim/random_world.h"
#include "tests/sim/simulation.h"

/// Random configurations, random receivers with random troubles: fail silent or fail explicit,
/// never fail stale.
namespace tribus::test {
namespace {

constexpr std::uint64_t kSeeds = 600;

std::optional<std::string> broken_in(std::uint64_t seed) {
    const RandomWorld world(seed);
    Simulation simulation(configuration_of(world.text()), world.senders(), seed);
    simulation.run_until(RandomWorld::kEnd);
    const auto broken = broken_promise(world, simulation);
    return broken ? std::optional(*broken + "\n" + world.text()) : std::nullopt;
}

TEST(NeverStale, no_random_world_breaks_a_promise) {
    for_each_seed(kSeeds, [](std::uint64_t seed) { EXPECT_EQ(broken_in(seed), std::nullopt); });
}

/// Seeds that tests/sim/run.sh found, before what they found was mended.
TEST(NeverStale, no_world_that_broke_one_once_does_again) {
    std::ifstream file(std::string(TRIBUS_SOURCE_DIR) + "/tests/sim/regression_seeds.txt");
    ASSERT_TRUE(file);
    for (std::string line; std::getline(file, line);) {
        std::uint64_t seed = 0;
        if (std::istringstream(line) >> seed) {
            EXPECT_EQ(broken_in(seed), std::nullopt) << line;
        }
    }
}

}  // namespace
}  // namespace tribus::test
