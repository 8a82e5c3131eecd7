#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/sim/linked_boards.h"

/// Two boards with a link on UDP or CAN in virtual time, and somebody who records it. The sender
/// may end, be suspended and start again, and both may reload.
namespace tribus::test::link_scene {

using namespace linked_boards;

/// The program looks so often whether the machine was suspended.
inline constexpr int kLookPeriod = 200;  ///< ms

struct Medium {
    const char* name;
    const char* lines;
};
inline constexpr std::array kMedia{
    Medium{"UDP", kUdp}, Medium{"FD", "protocol = \"can\"\ninterface = \"can0\"\nfd = true\n"},
    Medium{"classic", "protocol = \"can\"\ninterface = \"can0\"\n"}};

/// The shore, its radio, the boat with its servos, and who records between them.
class Scene {
  public:
    /// `keys`: lines of both ends.
    Scene(const Medium& medium, bool epoch, const std::string& keys)
        : link_(std::string(medium.lines) + (epoch ? kEpochLine : "")),
          shore_has_(shore_with(link_ + keys)),
          boat_(std::make_unique<Board>(boat_with(link_ + keys), at(0), boat_epoch_)) {
        start();
    }

    void reload_shore(const std::string& keys) {
        shore_->reload(shore_with(link_ + keys), shore_time());
    }
    void reload_boat(const std::string& keys) { boat_->reload(boat_with(link_ + keys), at(now_)); }
    void start() {
        shore_ = std::make_unique<Board>(shore_has_, shore_time(), shore_epoch_);
        begun_ = now_;
    }
    void end() {
        shore_->end(shore_time());
        carry(shore_->take_all());
        shore_.reset();
    }
    void kill() { shore_.reset(); }
    /// Its machine is suspended.
    void suspend() {
        asleep_ = std::move(shore_);
        asleep_since_ = now_;
    }
    /// It goes on. Its clock has stood still, or counted whole seconds.
    void wake() {
        const Instant since = at(asleep_since_ - behind_);
        const int duration = now_ - asleep_since_;
        behind_ += duration < 1000 ? duration : 700;
        shore_ = std::move(asleep_);
        shore_->wake(since, shore_time());
        begun_ = now_;
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
            for (const Bytes& frame : boat_->take()) {
                note(seen_in(frame));
            }
        }
    }
    /// Time from the latest start or wake until the servos were told sticks of after it, in ms;
    /// nothing if they are not within a minute.
    std::optional<int> time_to_control() {
        while (newest_ <= begun_) {
            if (now_ - begun_ > 60'000) {
                return std::nullopt;
            }
            run(1);
        }
        return now_ - begun_;
    }
    /// From now on what the shore sends does not reach the boat.
    void cut() { connected_ = false; }
    void join() { connected_ = true; }
    /// Plays all that was recorded, from its beginning on.
    void replay() {
        replays_ = true;
        replayed_ = 0;
        run(2 * static_cast<int>(recorded_.size()) + 1000);
        replays_ = false;
    }

    int controls() const { return controls_; }
    /// Age of the oldest sticks that the servos were told as good, in ms.
    int oldest() const { return oldest_; }

    /// Frames that the servos were told as bad, after the first good one.
    int marked() const { return marked_; }

  private:
    Instant shore_time() const { return at(now_ - behind_); }

    void step_shore() {
        if (now_ % kStickPeriod == 0) {
            shore_->receive(sticks(now_, kHonest), shore_time());
        }
        shore_->run_until(shore_time());
        carry(shore_->take_all());
    }
    void carry(std::vector<LinkMessage> said) {
        for (LinkMessage& one : said) {
            if (connected_) {
                for (const LinkMessage& answer : boat_->receive(one, at(now_))) {
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
            newest_ = std::max(newest_, seen.time);
            oldest_ = std::max(oldest_, now_ - seen.time);
        }
    }

    std::string link_;
    Configuration shore_has_;
    StoredNumbers shore_epoch_{1000};
    StoredNumbers boat_epoch_{0};
    std::unique_ptr<Board> shore_;
    std::unique_ptr<Board> asleep_;
    std::unique_ptr<Board> boat_;
    std::vector<LinkMessage> recorded_;
    std::size_t replayed_ = 0;
    bool connected_ = true;
    bool replays_ = false;
    int now_ = 0;
    int begun_ = 0;  ///< the latest run of the shore
    int asleep_since_ = 0;
    int behind_ = 0;  ///< of the shore's clock
    int controls_ = 0;
    int marked_ = 0;
    int newest_ = 0;
    int oldest_ = 0;
};

}  // namespace tribus::test::link_scene
