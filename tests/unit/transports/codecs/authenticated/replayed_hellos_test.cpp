#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/can_frame.h"
#include "tests/unit/transports/codecs/authenticated/link_bench.h"
#include "transports/codecs/authenticated/classic_ends.h"
#include "transports/codecs/authenticated/fd_ends.h"

/// Somebody without the key repeats recorded hellos while the sender starts again. In virtual time.
namespace tribus::test::replayed_hellos_test {
namespace {

using namespace authenticated_link;

/// How answers travel.
enum class Medium : std::uint8_t {
    bus,        ///< everybody hears them, and frames wait together until the receiver looks
    datagrams,  ///< an answer goes only to the address of the latest datagram
};

struct Attack {
    int replays = 10;            ///< in each second
    std::uint32_t sessions = 1;  ///< recorded ones
    bool own_session = false;    ///< the hellos of the sender itself, from elsewhere
    bool before_each = false;    ///< it foresees each hello by 1 ms, and does all just before it
};

struct Scene {
    Medium medium = Medium::bus;
    std::size_t receivers = 1;
    Duration look{};  ///< the receiver's thread looks so often
};

/// A sender that has started again after 1 s of control, its receivers, and the attacker.
class World {
  public:
    World(const Scene& scene, const Attack& attack, std::uint32_t seed)
        : scene_(scene), attack_(attack), random_(seed) {
        for (std::size_t i = 0; i < scene.receivers; ++i) {
            decoders_.push_back(std::make_unique<FdDecoder>(link()));
            decoders_.back()->use_seed(random_seed());
        }
        for (std::uint32_t i = 0; i < attack.sessions; ++i) {
            Sender recorded(LinkMacs(counted_secret(), kLink), seed_of(0x100000 + i));
            HelloMessage hello{};
            recorded.write_hello(hello, at(0ms));
            recorded_.push_back(fd_frame(kSenderId, false, hello));
        }
        start();
    }

    /// Runs the sender, starts it again, and returns the time from then until some receiver
    /// publishes again for 100 ms: 3 s if none does within 1.2 s.
    Duration time_to_control() {
        run_until(400ms);
        start();
        attacked_ = true;
        attack_begins_ = now_;
        published_.clear();
        run_until(1600ms);
        // The old session's silence is over by then; a single frame is no control.
        for (std::size_t i = 0; i + 4 < published_.size(); ++i) {
            if (published_[i + 4] - published_[i] <= 120ms) {
                return published_[i] - attack_begins_;
            }
        }
        return 3s;
    }

  private:
    static constexpr std::uint32_t kSenderId = 0x305;
    static constexpr Duration kStep = 200us;
    static constexpr Duration kPeriod = 20ms;

    FdLink link() const {
        FdLink link{.keys = {.name = std::string(kLink), .secret = counted_secret()},
                    .sender_id = kSenderId,
                    .receiver_id = 0x300};
        link.answers = scene_.medium == Medium::datagrams ? 1 : FdLink::kMostAnswers;
        return link;
    }
    RandomSeed random_seed() {
        RandomSeed seed{};
        for (auto& byte : seed) {
            byte = static_cast<std::uint8_t>(random_());
        }
        return seed;
    }
    void start() {
        encoder_ = std::make_unique<FdEncoder>(link());
        encoder_->use_seed(random_seed());
        phase_ = std::chrono::microseconds(random_() % 100) * 200;
    }

    void run_until(Duration end) {
        for (; now_ < end; now_ += kStep) {
            if (attacked_) {
                attack();
            }
            if ((now_ - phase_) % kPeriod == 0ms) {
                send();
            }
            if (scene_.look == 0ms || now_ % scene_.look == 0ms) {
                look();
            }
        }
    }
    void send() {
        std::vector<CanFrame> frames(kMostSnapshotFrames);
        const std::span<CanFrame, kMostSnapshotFrames> room(frames);
        frames.resize(encoder_->write(sticks(at(now_ - 1ms)), room, at(now_)));
        for (const CanFrame& frame : frames) {
            if (frame.length == kHelloBytes) {
                own_ = frame;
            }
        }
        if (attacked_ && attack_.before_each) {
            burst();
        }
        arrive(frames, true);
    }
    /// Next to each datagram of the sender, since it may have a hello.
    void burst() {
        const int each = static_cast<int>(attack_.replays * kPeriod / Duration(1s));
        for (int i = 0; i < each; ++i) {
            arrive({replay()}, false);
        }
    }
    void attack() {
        const auto due = (now_ - attack_begins_) * attack_.replays / Duration(1s);
        for (; !attack_.before_each && replayed_ <= due; ++replayed_) {
            arrive({replay()}, false);
        }
    }
    CanFrame replay() {
        return attack_.own_session && own_.length > 0 ? own_
                                                      : recorded_[next_++ % recorded_.size()];
    }

    void arrive(const std::vector<CanFrame>& frames, bool from_sender) {
        if (scene_.medium == Medium::bus) {
            waiting_.insert(waiting_.end(), frames.begin(), frames.end());
            return;
        }
        for (const auto& decoder : decoders_) {
            take(*decoder, frames);
            for (const CanFrame& answer : decoder->answer(at(now_))) {
                if (from_sender) {
                    encoder_->hear(answer, at(now_));
                }
            }
        }
    }
    void look() {
        for (const auto& decoder : decoders_) {
            take(*decoder, waiting_);
        }
        waiting_.clear();
        for (const auto& decoder : decoders_) {
            for (const CanFrame& answer : decoder->answer(at(now_))) {
                encoder_->hear(answer, at(now_));
            }
        }
    }
    void take(FdDecoder& decoder, const std::vector<CanFrame>& frames) {
        for (const CanFrame& frame : frames) {
            if (decoder.next(frame, at(now_))) {
                published_.push_back(now_);
            }
        }
    }

    Scene scene_;
    Attack attack_;
    std::mt19937 random_;
    std::vector<std::unique_ptr<FdDecoder>> decoders_;
    std::unique_ptr<FdEncoder> encoder_;
    std::vector<CanFrame> recorded_;
    std::vector<CanFrame> waiting_;
    CanFrame own_{};
    std::size_t next_ = 0;
    Duration now_{};
    Duration phase_{};
    Duration attack_begins_{};
    bool attacked_ = false;
    std::int64_t replayed_ = 0;
    std::vector<Duration> published_;
};

Duration longest_of(const Scene& scene, const Attack& attack) {
    constexpr std::uint32_t kSeeds = 12;
    Duration longest{};
    for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
        longest = std::max(longest, World(scene, attack, seed).time_to_control());
    }
    return longest;
}

class ReplayedHellos : public ::testing::TestWithParam<Attack> {};

TEST_P(ReplayedHellos, KeepNoSenderFromControlForASecondOnDatagrams) {
    EXPECT_LE(longest_of({.medium = Medium::datagrams}, GetParam()), 1s);
}

TEST_P(ReplayedHellos, KeepNoSenderFromControlForASecondOnABus) {
    EXPECT_LE(longest_of({}, GetParam()), 1s);
    EXPECT_LE(longest_of({.look = 5ms}, GetParam()), 1s) << "frames wait for a slow thread";
}

TEST_P(ReplayedHellos, KeepNoSenderFromControlForASecondWhereMoreReceiversAnswer) {
    EXPECT_LE(longest_of({.receivers = 3}, GetParam()), 1s);
}

INSTANTIATE_TEST_SUITE_P(
    AuthenticatedLink, ReplayedHellos,
    ::testing::Values(Attack{.replays = 10}, Attack{.replays = 50, .before_each = true},
                      Attack{.replays = 1000}, Attack{.replays = 1000, .before_each = true},
                      Attack{.replays = 1000, .sessions = 10},
                      Attack{.replays = 1000, .sessions = 10, .before_each = true},
                      Attack{.replays = 1000, .sessions = 5000},
                      Attack{.replays = 1000, .sessions = 5000, .before_each = true},
                      Attack{.replays = 1000, .own_session = true},
                      Attack{.replays = 1000, .own_session = true, .before_each = true}));

}  // namespace
}  // namespace tribus::test::replayed_hellos_test
