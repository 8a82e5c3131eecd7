#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/build/carry_over.h"
#include "tests/sim/linked_boards.h"

/// Two boards with a link on UDP or CAN in virtual time, and somebody who records it. The sender
/// may end, be suspended and start again, and both may reload.
namespace tribus::test::link_scene {

using namespace linked_boards;

/// The program looks so often whether the machine was suspended.
inline constexpr int kLookPeriod = 200;  ///< ms

/// What one output or input said: a datagram, or frames.
struct Said {
    Bytes datagram;
    std::vector<CanFrame> frames;
};

inline Said copy_of(const Transmission& sent) {
    return {{sent.bytes().begin(), sent.bytes().end()},
            {sent.can_frames().begin(), sent.can_frames().end()}};
}

/// A run of a program, in the time of its machine.
class Run : StationObserver {
  public:
    Run(const Configuration& configuration, Instant start, StoredNumbers& epoch)
        : epoch_(epoch),
          configuration_(configuration),
          engine_(build(configuration)),
          loop_(*engine_, *this, start) {
        epoch.start(start);
    }

    void run_until(Instant now) {
        loop_.run_until(now);
        epoch_.store();
    }
    /// Returns what it answers.
    std::vector<Said> receive(const Said& said, Instant now) {
        std::vector<Said> answers;
        const auto answer = [&] {
            if (const auto sent = engine_->answer(0, now); !sent.empty()) {
                answers.push_back(copy_of(sent));
            }
        };
        if (!said.datagram.empty()) {
            loop_.receive(input_station(0), said.datagram, now);
            engine_->datagram_ended(0, now);
            answer();
        }
        for (const CanFrame& frame : said.frames) {
            loop_.receive(input_station(0), frame, now);
            answer();
        }
        return answers;
    }
    void hear(const Said& said, Instant now) {
        const Station replies{StationKind::replies, 0};
        if (!said.datagram.empty()) {
            loop_.receive(replies, said.datagram, now);
        }
        for (const CanFrame& frame : said.frames) {
            loop_.receive(replies, frame, now);
        }
    }
    std::vector<Said> take() { return std::exchange(said_, {}); }
    /// Ends in order, and says its last.
    void end(Instant now) {
        loop_.end(now);
        epoch_.stop();
    }
    void reload(const Configuration& fresh, Instant now) {
        auto next = build(fresh);
        const CarryOver plan = plan_carry_over(configuration_, fresh);
        next->start(now);
        next->continue_from(*engine_, plan.engine, now);
        loop_.go_on_with(*next, nullptr, now);
        engine_ = std::move(next);
        configuration_ = fresh;
    }
    /// It did not run, and its machine's clock went on to `until` meanwhile.
    void wake(Instant since, Instant until) { loop_.come_back(since, until); }

  private:
    void wrote(Station /*station*/, Instant /*at*/, const Transmission& sent) override {
        said_.push_back(copy_of(sent));
    }

    std::unique_ptr<Engine> build(const Configuration& configuration) const {
        return build_engine(
            configuration, {},
            {.random = next_seed, .numbers = [this](const std::string&) { return &epoch_; }});
    }

    StoredNumbers& epoch_;
    Configuration configuration_;
    std::unique_ptr<Engine> engine_;
    std::vector<Said> said_;
    VirtualLoop loop_;
};

struct Medium {
    const char* name;
    const char* lines;
};
inline constexpr std::array kMedia{
    Medium{"UDP", "protocol = \"network\"\naddress = \"127.0.0.1:5700\"\n"},
    Medium{"FD", "protocol = \"can\"\ninterface = \"can0\"\nfd = true\n"},
    Medium{"classic", "protocol = \"can\"\ninterface = \"can0\"\n"}};

/// The shore, its radio, the boat with its servos, and who records between them.
class Scene {
  public:
    /// `keys`: lines of both ends.
    Scene(const Medium& medium, bool epoch, const std::string& keys)
        : link_(std::string(medium.lines) + (epoch ? kEpochLine : "")),
          shore_text_(shore_with(keys)),
          boat_(std::make_unique<Run>(boat_with(keys), at(0), boat_epoch_)) {
        start();
    }

    void reload_shore(const std::string& keys) { shore_->reload(shore_with(keys), shore_time()); }
    void reload_boat(const std::string& keys) { boat_->reload(boat_with(keys), at(now_)); }
    void start() { shore_ = std::make_unique<Run>(shore_text_, shore_time(), shore_epoch_); }
    void end() {
        shore_->end(shore_time());
        carry(shore_->take());
        shore_.reset();
    }
    void kill() { shore_.reset(); }
    /// Its clock counts only a part of the time.
    void suspend(int duration, int counted) {
        const Instant since = shore_time();
        std::unique_ptr<Run> asleep = std::move(shore_);
        run(duration);
        behind_ += duration - counted;
        shore_ = std::move(asleep);
        shore_->wake(since, shore_time());
        run(kLookPeriod);
        lose_clock();
    }
    void lose_clock() { shore_epoch_.lose_clock(shore_time()); }

    void run(int duration) {
        for (const int until = now_ + duration; now_ < until; ++now_) {
            if (shore_) {
                step_shore();
            }
            boat_->run_until(at(now_));
            if (replayed_ < recorded_.size() && replays_ && now_ % 2 == 0) {
                boat_->receive(recorded_[replayed_++], at(now_));
            }
            for (const Said& frame : boat_->take()) {
                note(seen_in(frame.datagram));
            }
        }
    }
    /// Time until control is back, in ms; nothing if it is not within a minute.
    std::optional<int> time_to_control() {
        const int since = now_;
        const int before = controls_;
        while (controls_ == before) {
            if (now_ - since > 60'000) {
                return std::nullopt;
            }
            run(1);
        }
        return now_ - since;
    }
    /// From now on what the shore sends does not reach the boat.
    void cut() { connected_ = false; }
    void join() { connected_ = true; }
    /// Plays all that was recorded.
    void replay() {
        replays_ = true;
        run(2 * static_cast<int>(recorded_.size()) + 1000);
        replays_ = false;
    }

    int controls() const { return controls_; }
    /// Age of the oldest sticks that the servos were told as good, in ms.
    int oldest() const { return oldest_; }

    /// Frames that the servos were told as bad, after the first good one.
    int marked() const { return marked_; }

  private:
    Configuration shore_with(const std::string& keys) const {
        return load("[input.radio]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n[output.boat]\n" +
                    link_ + keys + "[pipeline.main]\nfrom = \"radio\"\nto = \"boat\"\n");
    }
    Configuration boat_with(const std::string& keys) const {
        return load("[input.shore]\n" + link_ + keys + "timeout = \"" + std::to_string(kTimeout) +
                    "ms\"\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                    "[pipeline.main]\nfrom = \"shore\"\nto = \"servos\"\n");
    }
    Instant shore_time() const { return at(now_ - behind_); }

    void step_shore() {
        if (now_ % kStickPeriod == 0) {
            shore_->receive({sticks(now_, kHonest), {}}, shore_time());
        }
        shore_->run_until(shore_time());
        carry(shore_->take());
    }
    void carry(std::vector<Said> said) {
        for (Said& one : said) {
            if (connected_) {
                for (const Said& answer : boat_->receive(one, at(now_))) {
                    if (shore_) {
                        shore_->hear(answer, shore_time());
                    }
                }
            }
            if (!replays_) {
                recorded_.push_back(std::move(one));
            }
        }
    }
    void note(const Seen& seen) {
        marked_ += controls_ > 0 && seen.marked ? 1 : 0;
        if (!seen.marked) {
            ++controls_;
            oldest_ = std::max(oldest_, now_ - seen.time);
        }
    }

    std::string link_;
    Configuration shore_text_;
    StoredNumbers shore_epoch_{1000};
    StoredNumbers boat_epoch_{0};
    std::unique_ptr<Run> shore_;
    std::unique_ptr<Run> boat_;
    std::vector<Said> recorded_;
    std::size_t replayed_ = 0;
    bool connected_ = true;
    bool replays_ = false;
    int now_ = 0;
    int behind_ = 0;  ///< of the shore's clock
    int controls_ = 0;
    int marked_ = 0;
    int oldest_ = 0;
};

}  // namespace tribus::test::link_scene
