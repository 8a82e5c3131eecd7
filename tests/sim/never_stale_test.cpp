#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <random>
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
constexpr int kReloads = 10;

/// With `reloads`, spread over the time of the troubles.
std::optional<std::string> broken_in(std::uint64_t seed, WorldKind kind, int reloads = 0) {
    using namespace std::chrono_literals;
    const RandomWorld world(seed, kind);
    const Configuration configuration = configuration_of(world.text());
    Simulation simulation(configuration, world.senders(), seed);
    std::mt19937_64 random(seed);
    for (int reload = 0; reload < reloads; ++reload) {
        const auto early = std::chrono::microseconds(random() % 1'000'000);
        simulation.reload(configuration, Instant(20s * (reload + 1) / reloads - early));
    }
    simulation.run_until(RandomWorld::kEnd);
    const auto broken = broken_promise(world, simulation);
    return broken ? std::optional(*broken + "\n" + world.text()) : std::nullopt;
}

TEST(NeverStale, no_random_world_breaks_a_promise) {
    for_each_seed(kSeeds, [](std::uint64_t seed) {
        EXPECT_EQ(broken_in(seed, WorldKind::serial), std::nullopt);
    });
}

TEST(NeverStale, no_random_world_with_can_breaks_a_promise) {
    constexpr std::uint64_t kSeedsWithCan = 300;
    for_each_seed(kSeedsWithCan, [](std::uint64_t seed) {
        EXPECT_EQ(broken_in(seed, WorldKind::with_can), std::nullopt);
    });
}

TEST(NeverStale, no_reload_in_a_random_world_breaks_a_promise) {
    constexpr std::uint64_t kReloadedSeeds = 200;
    for_each_seed(kReloadedSeeds, [](std::uint64_t seed) {
        EXPECT_EQ(broken_in(seed, WorldKind::with_can, kReloads), std::nullopt);
    });
}

/// Seeds that tests/sim/run.sh found, before what they found was mended.
TEST(NeverStale, no_world_that_broke_one_once_does_again) {
    std::ifstream file(std::string(TRIBUS_SOURCE_DIR) + "/tests/sim/regression_seeds.txt");
    ASSERT_TRUE(file);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string kind;
        if (line.starts_with("can ") || line.starts_with("reload ")) {
            words >> kind;
        }
        std::uint64_t seed = 0;
        if (words >> seed) {
            const bool reloads = kind == "reload";
            EXPECT_EQ(broken_in(seed, kind.empty() ? WorldKind::serial : WorldKind::with_can,
                                reloads ? kReloads : 0),
                      std::nullopt)
                << line;
        }
    }
}

}  // namespace
}  // namespace tribus::test
