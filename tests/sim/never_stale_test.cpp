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

/// Random configurations and random receivers with random troubles: the program may fail silent or
/// fail explicit, but never fail stale.
namespace tribus::test::never_stale_test {
namespace {

/// Reloads and stalls of the program itself, spread over the time of the troubles.
struct OwnTroubles {
    int reloads = 0;
    int stalls = 0;
};
constexpr OwnTroubles kReloads{.reloads = 10};
constexpr OwnTroubles kStalls{.stalls = 15};

std::optional<std::string> broken_in(std::uint64_t seed, WorldKind kind, OwnTroubles own = {}) {
    using namespace std::chrono_literals;
    const RandomWorld world(seed, kind);
    const Configuration configuration = configuration_of(world.text());
    Simulation simulation(configuration, world.senders(), seed);
    std::mt19937_64 random(seed);
    const auto up_to = [&](Duration most) {
        return std::chrono::microseconds(random() % static_cast<std::uint64_t>(most / 1us));
    };
    for (int reload = 0; reload < own.reloads; ++reload) {
        simulation.reload(configuration, Instant(20s * (reload + 1) / own.reloads - up_to(1s)));
    }
    for (int stall = 0; stall < own.stalls; ++stall) {
        // Some stalls are shorter than any timeout, some are longer.
        const Instant since = Instant(20s * (stall + 1) / own.stalls - up_to(500ms));
        simulation.stall(since, since + up_to(stall % 3 == 0   ? 30ms
                                              : stall % 3 == 1 ? 200ms
                                                               : 800ms));
    }
    simulation.run_until(RandomWorld::kEnd);
    const auto broken = broken_promise(world, simulation);
    return broken ? std::optional(*broken + "\n" + world.text()) : std::nullopt;
}

void expect_promises_kept(std::uint64_t seeds, WorldKind kind, OwnTroubles own = {}) {
    for_each_seed(seeds,
                  [&](std::uint64_t seed) { EXPECT_EQ(broken_in(seed, kind, own), std::nullopt); });
}

TEST(NeverStale, NoRandomWorldBreaksAPromise) {
    expect_promises_kept(150, WorldKind::serial);
}

TEST(NeverStale, NoRandomWorldWithCanBreaksAPromise) {
    expect_promises_kept(75, WorldKind::with_can);
}

TEST(NeverStale, NoReloadInARandomWorldBreaksAPromise) {
    expect_promises_kept(50, WorldKind::with_can, kReloads);
}

TEST(NeverStale, NoReaderThatStallsInARandomWorldBreaksAPromise) {
    expect_promises_kept(75, WorldKind::with_can, kStalls);
}

TEST(NeverStaleInManyWorlds, NoRandomWorldBreaksAPromise) {
    expect_promises_kept(600, WorldKind::serial);
}

TEST(NeverStaleInManyWorlds, NoRandomWorldWithCanBreaksAPromise) {
    expect_promises_kept(300, WorldKind::with_can);
}

TEST(NeverStaleInManyWorlds, NoReloadInARandomWorldBreaksAPromise) {
    expect_promises_kept(200, WorldKind::with_can, kReloads);
}

TEST(NeverStaleInManyWorlds, NoReaderThatStallsInARandomWorldBreaksAPromise) {
    expect_promises_kept(300, WorldKind::with_can, kStalls);
}

/// Seeds that tests/sim/run.sh found before the faults were fixed.
TEST(NeverStale, NoWorldThatBrokeOneOnceDoesAgain) {
    std::ifstream file(std::string(TRIBUS_SOURCE_DIR) + "/tests/sim/regression_seeds.txt");
    ASSERT_TRUE(file);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string kind;
        if (line.starts_with("can ") || line.starts_with("reload ") || line.starts_with("stall ")) {
            words >> kind;
        }
        std::uint64_t seed = 0;
        if (words >> seed) {
            const OwnTroubles own = kind == "reload"  ? kReloads
                                    : kind == "stall" ? kStalls
                                                      : OwnTroubles{};
            EXPECT_EQ(broken_in(seed, kind.empty() ? WorldKind::serial : WorldKind::with_can, own),
                      std::nullopt)
                << line;
        }
    }
}

}  // namespace
}  // namespace tribus::test::never_stale_test
