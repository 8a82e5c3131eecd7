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
/// The boat may take sticks for younger than they are by this: the way, rounding, and clocks that
/// drift by 0.02 %.
constexpr int kMostUntold = 25;  ///< ms
/// The link sends with each third frame of the receiver, because its period is 20 ms.
constexpr int kLinkPeriod = 3 * kStickPeriod;  ///< ms

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
    static Way way() { return GetParam().way; }
    /// The sender is away, and still is after that long.
    static void go_away(Scene& scene, int away) {
        if (way() == Way::suspended) {
            scene.suspend();
        } else if (way() == Way::killed || way() == Way::power_lost) {
            scene.kill();
        } else {
            scene.end();
        }
        scene.run(away);
        if (way() == Way::started_twice) {
            scene.start();
            scene.run(300);
            scene.end();
            scene.run(away);
        }
    }
    static void come_back(Scene& scene) {
        if (way() == Way::suspended) {
            scene.wake();
            return;
        }
        if (way() == Way::power_lost) {
            scene.lose_clock();
        }
        scene.start();
    }
    static void expect_back(Scene& scene, int away) {
        const auto back = scene.time_to_control();
        ASSERT_TRUE(back) << "never, after " << away << " ms away";
        EXPECT_LE(*back, kBackWithin) << away << " ms away";
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

TEST_P(RestartedLink, IsBackWithinTwoSecondsAndStays) {
    for (const int away : {100, 300, 400, 1000, 4000, 20'000, 60'000}) {
        Scene scene = new_scene();
        scene.run(kRuns);
        ASSERT_GT(scene.controls(), 0);
        go_away(scene, away);
        come_back(scene);
        expect_back(scene, away);
        scene.run(4000);
        const int controls = scene.controls();
        const int marked = scene.marked();
        scene.run(1000);
        EXPECT_GE(scene.controls() - controls, 1000 / kLinkPeriod) << away << " ms away";
        EXPECT_EQ(scene.marked(), marked) << away << " ms away";
        EXPECT_LE(scene.oldest(), kTimeout + kMostUntold) << away << " ms away";
    }
}

/// Who is on the way keeps all of the sender's end to himself, and where its clock goes on, a whole
/// further run. He plays that to the boat while the sender is away, and again when it is back.
/// Where the machine itself started again or was suspended, no one can tell what a further run
/// sent then from what is sent now.
TEST_P(RestartedLink, MovesNothingByWhatWasRecordedBefore) {
    for (const int away : {100, 1000, 4000}) {
        Scene scene = new_scene();
        scene.run(kRuns);
        ASSERT_GT(scene.controls(), 0);
        scene.cut();
        scene.run(1000);
        if (way() != Way::power_lost && way() != Way::suspended) {
            go_away(scene, away);
            come_back(scene);
            scene.run(1000);
        }
        go_away(scene, away);
        const int before = scene.controls();
        scene.replay();
        EXPECT_EQ(scene.controls(), before) << away << " ms away";
        scene.join();
        come_back(scene);
        expect_back(scene, away);
        scene.replay();
        EXPECT_LE(scene.oldest(), kTimeout + kMostUntold) << away << " ms away";
    }
}

}  // namespace
}  // namespace tribus::test::restarted_link_test
