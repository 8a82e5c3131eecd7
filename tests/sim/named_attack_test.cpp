#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/sim/linked_boards.h"

/// Each attack on a link by itself: the link without a key falls to it, the one with a key does
/// not.
namespace tribus::test::named_attack_test {
namespace {

using namespace linked_boards;

constexpr int kAttackBegins = 7000;  ///< ms
constexpr int kAttackEnds = 29000;   ///< ms
/// The link without a key counts its snapshots, and the counter comes round after so many. So the
/// attacks are long enough for that.
constexpr std::size_t kCounterValues = 256;
/// Place of the counter in a datagram without a key (docs/protocols/network.md).
constexpr std::size_t kCounterByte = 6;
/// The default of `period`.
constexpr int kDatagramPeriod = 20;  ///< ms

/// The proof of a link's snapshots.
enum class Proof : std::uint8_t { none, challenges, epoch };

std::string lines_of(const KeyFiles& keys, const std::string& key, Proof proof) {
    return proof == Proof::none         ? ""
           : proof == Proof::challenges ? keys.line(key)
                                        : keys.line(key) + kEpochLine;
}

/// Both boards and somebody on the way between them.
class Scene {
  public:
    Scene(const KeyFiles& keys, Proof proof)
        : boards_(lines_of(keys, "boat.key", proof)),
          strangers_(lines_of(keys, "attacker.key", proof)),
          shore_(std::make_unique<Board>(boards_.shore, at(0), shore_epoch_)),
          boat_(std::make_unique<Board>(boards_.boat, at(0), boat_epoch_)),
          has_key_(proof != Proof::none) {}

    /// Goes on until then. `step` is called each millisecond.
    void run_until(int end, const std::function<void()>& step = {}) {
        for (; now_ < end; ++now_) {
            if (now_ % kStickPeriod == 0) {
                shore_->receive(sticks(now_, kHonest), at(now_));
            }
            shore_->run_until(at(now_));
            boat_->run_until(at(now_));
            for (Bytes& datagram : shore_->take()) {
                from_shore(std::move(datagram));
            }
            if (step) {
                step();
            }
            for (const Bytes& frame : boat_->take()) {
                note(seen_in(frame));
            }
        }
    }
    void to_boat(const Bytes& datagram) {
        if (const Bytes answer = boat_->receive(datagram, at(now_)); !answer.empty()) {
            answered(answer);
        }
    }

    bool has_key() const { return has_key_; }
    int now() const { return now_; }
    bool attacked() const { return now_ >= kAttackBegins; }
    void restart_boat() { boat_ = std::make_unique<Board>(boards_.boat, at(now_), boat_epoch_); }
    void restart_shore() {
        shore_ = std::make_unique<Board>(boards_.shore, at(now_), shore_epoch_);
    }
    /// Another sender; with the key of the boats, or with the attacker's.
    Board other_sender(bool has_key) {
        return Board(has_key ? boards_.shore : strangers_.shore, at(now_), other_epoch_);
    }

    /// The way of datagrams of the sender, and of answers.
    std::function<void(Bytes)> from_shore = [this](const Bytes& datagram) { to_boat(datagram); };
    std::function<void(const Bytes&)> answered = [this](const Bytes& answer) {
        shore_->hear(answer, at(now_));
    };

    bool worked = false;  ///< frames in control before the attack began
    /// Frames in control that the servos saw since then.
    int controls = 0;
    int forged = 0;
    int oldest = 0;  ///< ms
    int back_in_time = 0;
    int changes_of_sender = 0;

  private:
    void note(const Seen& seen) {
        worked = worked || !seen.marked;
        if (seen.marked || !attacked()) {
            return;
        }
        ++controls;
        forged += seen.mark == kForged ? 1 : 0;
        oldest = std::max(oldest, now_ - seen.time);
        back_in_time += seen.time < latest_.time ? 1 : 0;
        changes_of_sender += controls > 1 && seen.mark != latest_.mark ? 1 : 0;
        latest_ = seen;
    }

    Boards boards_;
    Boards strangers_;
    StoredNumbers shore_epoch_{1000};
    StoredNumbers boat_epoch_{0};
    StoredNumbers other_epoch_{1'000'000'000};
    std::unique_ptr<Board> shore_;
    std::unique_ptr<Board> boat_;
    bool has_key_;
    int now_ = 0;
    Seen latest_;
};

/// A recording of what the sender said for some seconds, ready to be sent again.
class Recording {
  public:
    explicit Recording(Scene& scene) : scene_(scene) {
        scene.from_shore = [&](const Bytes& datagram) {
            if (!scene.attacked()) {
                kept_.push_back(datagram);
                scene.to_boat(datagram);
            }
        };
        scene.run_until(6000);
    }
    /// Sends the next one if it is time.
    void play() {
        if (scene_.now() % kDatagramPeriod == 0 && next_ < kept_.size()) {
            scene_.to_boat(kept_[next_++]);
        }
    }

  private:
    Scene& scene_;
    std::vector<Bytes> kept_;
    std::size_t next_ = 0;
};

struct Attack {
    const char* name;
    /// Returns whether the link fell to it.
    bool (*falls)(Scene&);
};

bool falls_to_replay(Scene& scene) {
    Recording recording(scene);
    scene.run_until(kAttackBegins);
    scene.run_until(kAttackEnds, [&] { recording.play(); });
    return scene.oldest > kTimeout;
}

bool falls_to_replay_after_a_restart_of_the_receiver(Scene& scene) {
    Recording recording(scene);
    scene.run_until(kAttackBegins);
    scene.restart_boat();
    scene.run_until(kAttackEnds, [&] { recording.play(); });
    return scene.oldest > kTimeout;
}

/// The new sender may ask and be answered; what it sends then is lost.
bool falls_to_replay_after_a_restart_of_the_sender(Scene& scene) {
    Recording recording(scene);
    scene.run_until(kAttackBegins);
    scene.restart_shore();
    scene.from_shore = [&](const Bytes& datagram) {
        constexpr std::size_t kHelloDatagram = 28;
        if (datagram.size() == kHelloDatagram) {
            scene.to_boat(datagram);
        }
    };
    scene.run_until(kAttackEnds, [&] { recording.play(); });
    return scene.oldest > kTimeout;
}

/// Delays what comes by what `delay` says at that time.
bool falls_to_delay(Scene& scene, int (*delay)(int now)) {
    std::vector<std::pair<int, Bytes>> way;
    scene.from_shore = [&](const Bytes& datagram) {
        way.emplace_back(scene.now() + delay(scene.now()), datagram);
    };
    scene.run_until(kAttackEnds, [&] {
        std::erase_if(way, [&](const auto& one) {
            const bool due = one.first <= scene.now();
            if (due) {
                scene.to_boat(one.second);
            }
            return due;
        });
    });
    return scene.oldest > kTimeout + kStickPeriod;
}

bool falls_to_delay_at_once(Scene& scene) {
    return falls_to_delay(scene, [](int now) { return now < kAttackBegins ? 0 : 800; });
}

/// No datagram comes much later after the one before than it was sent.
bool falls_to_delay_that_grows(Scene& scene) {
    return falls_to_delay(
        scene, [](int now) { return now < kAttackBegins ? 0 : (now - kAttackBegins) / 3; });
}

/// As many datagrams as the counter has values come before those that were sent before them.
bool falls_to_reordering(Scene& scene) {
    std::vector<Bytes> way;
    scene.from_shore = [&](const Bytes& datagram) {
        if (!scene.attacked()) {
            scene.to_boat(datagram);
        } else if (way.size() < 2 * kCounterValues) {
            way.push_back(datagram);
        }
    };
    std::size_t next = 0;
    scene.run_until(kAttackEnds, [&] {
        if (way.size() == 2 * kCounterValues && next < way.size() &&
            scene.now() % kDatagramPeriod == 0) {
            scene.to_boat(way[(next++ + kCounterValues) % way.size()]);
        }
    });
    return scene.back_in_time > 0;
}

/// A second board with the same key. Each 10 datagrams another one of them is the sender: somebody
/// on the way takes its newest, or where there is no key, the one with the right counter.
bool falls_to_two_senders(Scene& scene) {
    Board second = scene.other_sender(true);
    const auto to_first = scene.answered;
    scene.answered = [&](const Bytes& answer) {
        to_first(answer);
        second.hear(answer, at(scene.now()));
    };
    std::vector<Bytes> of_second(kCounterValues);
    std::size_t sent = 0;
    scene.from_shore = [&](const Bytes& datagram) {
        const Bytes& other = of_second[scene.has_key() ? 0 : datagram[kCounterByte]];
        const bool swaps = scene.attacked() && sent++ / 10 % 2 == 1 && !other.empty();
        scene.to_boat(swaps ? other : datagram);
    };
    scene.run_until(kAttackEnds, [&] {
        if (scene.now() % kStickPeriod == 0) {
            second.receive(sticks(scene.now(), kForged), at(scene.now()));
        }
        second.run_until(at(scene.now()));
        for (const Bytes& datagram : second.take()) {
            of_second[scene.has_key() ? 0 : datagram[kCounterByte]] = datagram;
        }
    });
    return scene.changes_of_sender > 2;
}

/// While the sender is silent somebody sends in its place.
bool falls_to_forgery(Scene& scene) {
    scene.run_until(kAttackBegins);
    Board forger = scene.other_sender(false);
    scene.from_shore = [](const Bytes& /*lost*/) {};
    scene.answered = [&](const Bytes& answer) { forger.hear(answer, at(scene.now())); };
    scene.run_until(kAttackEnds, [&] {
        if (scene.now() % kStickPeriod == 0) {
            forger.receive(sticks(scene.now(), kForged), at(scene.now()));
        }
        forger.run_until(at(scene.now()));
        for (const Bytes& datagram : forger.take()) {
            scene.to_boat(datagram);
        }
    });
    return scene.forged > 0;
}

class NamedAttack : public testing::TestWithParam<Attack> {
  protected:
    KeyFiles keys_;
};

INSTANTIATE_TEST_SUITE_P(Attacks, NamedAttack,
                         testing::Values(Attack{"Replay", falls_to_replay},
                                         Attack{"ReplayAfterARestartOfTheReceiver",
                                                falls_to_replay_after_a_restart_of_the_receiver},
                                         Attack{"ReplayAfterARestartOfTheSender",
                                                falls_to_replay_after_a_restart_of_the_sender},
                                         Attack{"DelayAtOnce", falls_to_delay_at_once},
                                         Attack{"DelayThatGrows", falls_to_delay_that_grows},
                                         Attack{"Reordering", falls_to_reordering},
                                         Attack{"TwoSenders", falls_to_two_senders},
                                         Attack{"Forgery", falls_to_forgery}),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST_P(NamedAttack, WinsOnlyWithoutAKey) {
    Scene plain(keys_, Proof::none);
    EXPECT_TRUE(GetParam().falls(plain));
    for (const Proof proof : {Proof::challenges, Proof::epoch}) {
        Scene keyed(keys_, proof);
        EXPECT_FALSE(GetParam().falls(keyed));
        EXPECT_TRUE(keyed.worked);
    }
}

/// A box that sends what its own receiver says to a display, and has servos that the shore moves.
/// Somebody sends its own datagrams back to it.
class Reflection : public testing::Test {
  protected:
    /// Returns whether its own sticks moved its servos.
    static bool moves_servos(const std::string& to_boat, const std::string& to_display) {
        const Configuration boat_has =
            load("[input.shore]\nprotocol = \"network\"\naddress = \"127.0.0.1:5700\"\n" + to_boat +
                 "[input.radio]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n"
                 "[output.display]\nprotocol = \"network\"\naddress = \"127.0.0.1:5701\"\n" +
                 to_display +
                 "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                 "[pipeline.main]\nfrom = \"shore\"\nto = \"servos\"\n" +
                 kSilence + "[pipeline.show]\nfrom = \"radio\"\nto = \"display\"\n");
        const Configuration display_has = load(
            "[input.boat]\nprotocol = \"network\"\naddress = \"127.0.0.1:5701\"\n" + to_display +
            "[output.screen]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyC\"\n"
            "[pipeline.main]\nfrom = \"boat\"\nto = \"screen\"\n");
        StoredNumbers none(0);
        Board boat(boat_has, at(0), none);
        Board display(display_has, at(0), none);
        bool shown = false;
        bool moved = false;
        for (int now = 0; now < 5000; ++now) {
            if (now % kStickPeriod == 0) {
                boat.receive(sticks(now, kHonest), at(now), 1);
            }
            boat.run_until(at(now));
            display.run_until(at(now));
            for (const Bytes& datagram : boat.take(0)) {
                if (const Bytes answer = display.receive(datagram, at(now)); !answer.empty()) {
                    boat.hear(answer, at(now));
                }
                boat.receive(datagram, at(now));
            }
            const auto is_good = [](const Bytes& frame) { return !seen_in(frame).marked; };
            shown = shown || std::ranges::any_of(display.take(), is_good);
            moved = moved || std::ranges::any_of(boat.take(1), is_good);
        }
        EXPECT_TRUE(shown) << "the display shows what the boat sends";
        return moved;
    }

    KeyFiles keys_;
};

TEST_F(Reflection, WinsOnlyWithoutAKey) {
    EXPECT_TRUE(moves_servos("", ""));
    const std::string key = keys_.line("boat.key");
    EXPECT_FALSE(moves_servos(key + "link = \"to boat\"\n", key + "link = \"to display\"\n"));
}

}  // namespace
}  // namespace tribus::test::named_attack_test
