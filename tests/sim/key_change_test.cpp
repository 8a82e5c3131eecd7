#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "tests/sim/link_scene.h"

/// The steps by which the key of a link is changed (docs/protocols/network.md, "Change the key").
namespace tribus::test::key_change_test {
namespace {

using namespace link_scene;

constexpr int kStep = 3000;  ///< ms
/// Age of sticks at the servos: a period of each board.
constexpr int kMostUsual = 50;  ///< ms
/// The same where the sender begins a new session, as a sender that starts again.
constexpr int kMostAtTheSender = 550;  ///< ms
/// Half a second is at the edge of `timeout`: the servos hold for a frame or two.
constexpr int kMostMarked = 2;
/// A frame of SBUS may be on its way at the reload.
constexpr int kServoPeriod = 14;  ///< ms

class KeyChange : public testing::TestWithParam<std::tuple<Medium, bool>> {
  protected:
    Scene new_scene() const { return {medium(), epoch(), old_}; }
    static Medium medium() { return std::get<0>(GetParam()); }
    static bool epoch() { return std::get<1>(GetParam()); }

    KeyFiles keys_;
    std::string old_ = keys_.line("boat.key");
    std::string new_ = keys_.line("attacker.key");
    std::string both_ = new_ + "old_" + old_;
};

INSTANTIATE_TEST_SUITE_P(All, KeyChange,
                         testing::Combine(testing::ValuesIn(kMedia), testing::Bool()),
                         [](const auto& tried) {
                             return std::string(std::get<0>(tried.param).name) +
                                    (std::get<1>(tried.param) ? "Epoch" : "Answers");
                         });

TEST_P(KeyChange, DoesNotInterruptControl) {
    Scene scene = new_scene();
    scene.run(kStep);
    ASSERT_GT(scene.controls(), 0);
    const int usual = scene.oldest();
    EXPECT_LE(usual, kMostUsual);
    scene.reload_boat(both_);
    scene.run(kStep);
    EXPECT_LE(scene.oldest(), kMostUsual) << "step 2";
    EXPECT_EQ(scene.marked(), 0) << "step 2";
    scene.reload_shore(new_);
    scene.run(kStep);
    const int oldest = scene.oldest();
    const int marked = scene.marked();
    EXPECT_LE(oldest, epoch() ? kMostUsual : kMostAtTheSender) << "step 3";
    EXPECT_LE(marked, epoch() ? 0 : kMostMarked) << "step 3";
    scene.reload_boat(new_);
    scene.run(kStep);
    EXPECT_EQ(scene.oldest(), oldest) << "step 4";
    EXPECT_EQ(scene.marked(), marked) << "step 4";
}

/// A key that was taken away: its holder does not go on.
TEST_P(KeyChange, ToAnotherOneAtOnceEndsTheLink) {
    Scene scene = new_scene();
    scene.run(kStep);
    scene.reload_boat(new_);
    scene.run(kServoPeriod);
    const int before = scene.controls();
    scene.run(kStep);
    EXPECT_EQ(scene.controls(), before);
}

/// The order of snapshots goes on too: none of before counts again.
TEST_P(KeyChange, LetsNothingRecordedCountAgain) {
    Scene scene = new_scene();
    scene.run(kStep);
    scene.kill();
    scene.run(1000);
    scene.reload_boat(both_);
    const int before = scene.controls();
    scene.replay();
    EXPECT_EQ(scene.controls(), before);
}

}  // namespace
}  // namespace tribus::test::key_change_test
