#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <ostream>
#include <string>
#include <vector>

#include "tests/sim/link_scene.h"

/// A link with a key whose sender ends, is suspended or starts again, and somebody who recorded it
/// before: control comes back by itself, and nothing that was recorded counts.
namespace tribus::test::restarted_link_test {
namespace {

using namespace link_scene;

constexpr int kRuns = 4000;        ///< ms, of the sender, before it ends
constexpr int kBackWithin = 2000;  ///< ms
/// The delay of what comes is told to so much: the way, rounding, and clocks that drift by 0.02 %.
constexpr int kMostUntold = 25;  ///< ms

/// How the sender goes away.
enum class Way { ended, killed, power_lost, suspended, started_twice };

struct Case {
    Medium medium;
    bool epoch;
    Way way;
};

std::ostream& operator<<(std::ostream& out, const Case& tried) {
    constexpr std::array kWays{"ended", "killed", "power_lost", "suspended", "started_twice"};
    return out << tried.medium.name << (tried.epoch ? "_epoch_" : "_answers_")
               << kWays[static_cast<std::size_t>(tried.way)];
}

class RestartedLink : public testing::TestWithParam<Case> {
  protected:
    Scene new_scene() const {
        return {GetParam().medium, GetParam().epoch, keys_.line("boat.key")};
    }
    /// The sender is away for that long, and is there again at the end.
    static void go_away(Scene& scene, Way way, int away) {
        if (way == Way::suspended) {
            // No clock, or one with whole seconds, runs meanwhile.
            scene.suspend(away, away < 1000 ? 0 : away - 700);
            return;
        }
        for (int turn = 0; turn < (way == Way::started_twice ? 2 : 1); ++turn) {
            if (turn > 0) {
                scene.start();
                scene.run(300);
            }
            if (way == Way::ended || way == Way::started_twice) {
                scene.end();
            } else {
                scene.kill();
            }
            scene.run(away);
        }
        if (way == Way::power_lost) {
            scene.lose_clock();
        }
        scene.start();
    }

    KeyFiles keys_;
};

std::vector<Case> all_cases() {
    std::vector<Case> cases;
    for (const Medium& medium : kMedia) {
        for (const bool epoch : {false, true}) {
            for (const Way way :
                 {Way::ended, Way::killed, Way::power_lost, Way::suspended, Way::started_twice}) {
                cases.push_back({medium, epoch, way});
            }
        }
    }
    return cases;
}

INSTANTIATE_TEST_SUITE_P(All, RestartedLink, testing::ValuesIn(all_cases()),
                         [](const auto& tried) { return testing::PrintToString(tried.param); });

TEST_P(RestartedLink, IsBackWithinTwoSeconds) {
    for (const int away : {100, 300, 400, 1000, 4000, 20'000, 60'000}) {
        Scene scene = new_scene();
        scene.run(kRuns);
        ASSERT_GT(scene.controls(), 0);
        go_away(scene, GetParam().way, away);
        const auto back = scene.time_to_control();
        ASSERT_TRUE(back) << "never, after " << away << " ms away";
        EXPECT_LE(*back, kBackWithin) << away << " ms away";
        scene.run(5000);
        EXPECT_LE(scene.oldest(), kTimeout + kMostUntold) << away << " ms away";
    }
}

/// Who is on the way keeps all of its end and of the runs after it to himself, and plays that to
/// the boat while the sender is away, and again when it is back. Where the machine itself started
/// again, no one can tell what was sent then from what is sent now.
TEST_P(RestartedLink, MovesNothingByWhatWasRecordedBefore) {
    const bool clock_goes_on =
        GetParam().way != Way::power_lost && GetParam().way != Way::suspended;
    for (const int away : {100, 1000, 4000}) {
        Scene scene = new_scene();
        scene.run(kRuns);
        ASSERT_GT(scene.controls(), 0);
        scene.cut();
        scene.run(1000);
        if (clock_goes_on) {
            go_away(scene, GetParam().way, away);
            scene.run(1000);
            scene.end();
            scene.run(away);
        } else {
            scene.kill();
        }
        const int before = scene.controls();
        scene.replay();
        EXPECT_EQ(scene.controls(), before) << away << " ms away";
        EXPECT_LE(scene.oldest(), kTimeout + kMostUntold);
        scene.join();
        scene.start();
        const auto back = scene.time_to_control();
        ASSERT_TRUE(back);
        EXPECT_LE(*back, kBackWithin) << away << " ms away";
    }
}

}  // namespace
}  // namespace tribus::test::restarted_link_test
