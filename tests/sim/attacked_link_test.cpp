#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/sim/linked_boards.h"

/// A thousand random worlds of two boards with a link, each another attack.
namespace tribus::test::attacked_link_test {
namespace {

using namespace linked_boards;

constexpr std::uint32_t kWorlds = 200;
constexpr std::uint32_t kManyWorlds = 1000;
constexpr int kAttacked = 3000;  ///< ms
constexpr int kEnd = 6000;       ///< ms
/// A receiver that does not answer is deaf for 20 s after it was killed.
constexpr int kDeaf = 20'000;  ///< ms
constexpr std::size_t kMostKept = 200;

/// The promises that a world can break.
enum class Broken : std::uint8_t { none, forged, too_old, back_in_time, lost_at_the_end };

class World {
  public:
    World(const Boards& boards, const Boards& attackers, std::uint32_t seed)
        : boards_(boards),
          end_(kEnd + (boards.epoch ? kDeaf : 0)),
          random_(seed),
          shore_(std::make_unique<Board>(boards.shore, at(0), shore_epoch_)),
          boat_(std::make_unique<Board>(boards.boat, at(0), boat_epoch_)),
          attacker_(attackers.shore, at(0), attacker_epoch_),
          lost_percent_(random_.below(60)),
          longest_delay_(random_.below(2) == 0 ? 40 : 1500) {}

    Broken run() {
        for (now_ = 0; now_ < end_ && broken_ == Broken::none; ++now_) {
            step();
        }
        const bool controlled = controlled_at_ > end_ - 100;
        return broken_ == Broken::none && !controlled ? Broken::lost_at_the_end : broken_;
    }
    std::size_t controlled() const { return controlled_; }

  private:
    struct OnTheWay {
        int due = 0;
        bool to_boat = false;
        Bytes datagram;
    };

    bool attacked() const { return now_ < kAttacked; }
    bool percent(std::uint32_t share) { return random_.below(100) < share; }
    bool permille(std::uint32_t share) { return random_.below(1000) < share; }

    void step() {
        const Instant now = at(now_);
        if (now_ % kStickPeriod == 0) {
            shore_->receive(sticks(now_, kHonest), now);
        }
        shore_->run_until(now);
        boat_->run_until(now);
        for (Bytes& datagram : shore_->take()) {
            send(true, std::move(datagram));
        }
        judge(boat_->take());
        if (attacked()) {
            attack();
        }
        deliver();
    }

    /// The attacker sees everything.
    void send(bool to_boat, Bytes datagram) {
        kept_.push_back({0, to_boat, datagram});
        if (kept_.size() > kMostKept) {
            kept_.erase(kept_.begin());
        }
        if (!attacked()) {
            way_.push_back({now_ + 1, to_boat, std::move(datagram)});
        } else if (!percent(lost_percent_)) {
            way_.push_back({now_ + delay(), to_boat, std::move(datagram)});
        }
    }
    int delay() { return static_cast<int>(random_.below(longest_delay_)); }

    void attack() {
        if (now_ % kStickPeriod == 0) {
            attacker_.receive(sticks(now_, kForged), at(now_));
        }
        attacker_.run_until(at(now_));
        for (Bytes& datagram : attacker_.take()) {
            way_.push_back({now_, true, std::move(datagram)});
        }
        if (!kept_.empty() && permille(100)) {
            OnTheWay again = kept_[random_.below(static_cast<std::uint32_t>(kept_.size()))];
            again.due = now_ + delay();
            again.to_boat = again.to_boat != percent(20);
            if (percent(30)) {
                again.datagram[random_.below(static_cast<std::uint32_t>(again.datagram.size()))] ^=
                    static_cast<std::uint8_t>(1U << random_.below(8));
            }
            way_.push_back(std::move(again));
        }
        if (permille(1)) {
            shore_ = restarted(boards_.shore, shore_epoch_);
        }
        if (permille(1)) {
            boat_ = restarted(boards_.boat, boat_epoch_);
            newest_ = boards_.epoch ? newest_ : 0;
        }
    }

    std::unique_ptr<Board> restarted(const Configuration& configuration, StoredNumbers& epoch) {
        if (percent(50)) {
            epoch.stop();
        }
        return std::make_unique<Board>(configuration, at(now_), epoch);
    }

    void deliver() {
        for (std::size_t i = 0; i < way_.size();) {
            if (way_[i].due > now_) {
                ++i;
                continue;
            }
            const OnTheWay arrived = std::exchange(way_[i], way_.back());
            way_.pop_back();
            if (!arrived.to_boat) {
                shore_->hear(arrived.datagram, at(now_));
                if (attacked()) {
                    attacker_.hear(arrived.datagram, at(now_));
                }
            } else if (Bytes answer = boat_->receive(arrived.datagram, at(now_)); !answer.empty()) {
                send(false, std::move(answer));
            }
        }
    }

    void judge(const std::vector<Bytes>& frames) {
        for (const Bytes& frame : frames) {
            const Seen seen = seen_in(frame);
            if (seen.marked) {
                continue;
            }
            ++controlled_;
            controlled_at_ = now_;
            // A receiver that does not answer cannot know the delay of the quickest snapshot.
            const bool too_old = now_ - seen.time > kTimeout && !boards_.epoch;
            broken_ = seen.mark != kHonest  ? Broken::forged
                      : too_old             ? Broken::too_old
                      : seen.time < newest_ ? Broken::back_in_time
                                            : broken_;
            newest_ = seen.time;
        }
    }

    const Boards& boards_;
    int end_;
    Random random_;
    StoredNumbers shore_epoch_{1000};
    StoredNumbers boat_epoch_{0};
    StoredNumbers attacker_epoch_{1'000'000'000};
    std::unique_ptr<Board> shore_;
    std::unique_ptr<Board> boat_;
    Board attacker_;
    std::uint32_t lost_percent_;
    std::uint32_t longest_delay_;
    std::vector<OnTheWay> way_;
    std::vector<OnTheWay> kept_;
    int now_ = 0;
    int newest_ = 0;
    int controlled_at_ = 0;
    std::size_t controlled_ = 0;
    Broken broken_ = Broken::none;
};

class AttackedLink : public ::testing::Test {
  protected:
    /// No world breaks a promise, and the sticks of the key's holder come through.
    void expect_only_its_holder_controls(const std::string& epoch, std::uint32_t worlds) const {
        const Boards boards(keys_.line("boat.key") + epoch);
        const Boards attackers(keys_.line("attacker.key") + epoch);
        std::size_t controlled = 0;
        for (std::uint32_t seed = 1; seed <= worlds; ++seed) {
            World world(boards, attackers, seed);
            ASSERT_EQ(world.run(), Broken::none) << "seed " << seed;
            controlled += world.controlled();
        }
        EXPECT_GT(controlled / worlds, 200U) << "frames of control a world";
    }

    KeyFiles keys_;
};

TEST_F(AttackedLink, WithAKeyGivesControlOnlyToFreshFramesOfItsHolder) {
    expect_only_its_holder_controls("", kWorlds);
}

/// It goes on where it ended, also after both boards started again.
TEST_F(AttackedLink, WithAnEpochGivesControlOnlyToNewFramesOfItsHolder) {
    expect_only_its_holder_controls(kEpochLine, kWorlds / 4);
}

/// For the second tier.
class AttackedLinkInManyWorlds : public AttackedLink {};

TEST_F(AttackedLinkInManyWorlds, WithAKeyGivesControlOnlyToFreshFramesOfItsHolder) {
    expect_only_its_holder_controls("", kManyWorlds);
}

TEST_F(AttackedLinkInManyWorlds, WithAnEpochGivesControlOnlyToNewFramesOfItsHolder) {
    expect_only_its_holder_controls(kEpochLine, kManyWorlds / 4);
}

/// The same attacks work where there is no key, so the test above can see them.
TEST_F(AttackedLink, WithoutAKeyFallsToTheSameAttacks) {
    const Boards boards("");
    std::array<std::size_t, 5> worlds{};
    for (std::uint32_t seed = 1; seed <= 100; ++seed) {
        World world(boards, boards, seed);
        ++worlds[static_cast<std::size_t>(world.run())];
    }
    EXPECT_GT(worlds[static_cast<std::size_t>(Broken::forged)], 0U);
    EXPECT_LT(worlds[static_cast<std::size_t>(Broken::none)], 50U);
}

}  // namespace
}  // namespace tribus::test::attacked_link_test
