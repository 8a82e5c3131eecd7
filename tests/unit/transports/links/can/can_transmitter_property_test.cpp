#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "transports/links/can/can_transmitter.h"

namespace tribus::can_transmitter_property_test {
namespace {

using namespace std::chrono_literals;

/// Drives a transmitter at random and checks its promises. The data of each frame is the number of
/// its offer; its id has the lane and the part.
class Promises {
  public:
    void advance(Duration step) { now_ += step; }

    void offer() {
        const auto lane = *rc::gen::inRange<std::size_t>(0, 3);
        const auto count = *rc::gen::inRange<std::size_t>(1, kMostSnapshotFrames + 1);
        ++offers_;
        std::vector<CanFrame> frames(count);
        for (std::size_t part = 0; part < count; ++part) {
            CanFrame& made = frames[part];
            made.id = static_cast<std::uint32_t>(lane << 8 | part);
            made.length = 4;
            for (std::size_t byte = 0; byte < 4; ++byte) {
                made.data[byte] = static_cast<std::uint8_t>(offers_ >> (8 * byte));
            }
        }
        const WriteStatus status = transmitter_.offer(lane, frames, now_);
        if (status == WriteStatus::written) {
            offered_at_[offers_] = now_;
            newest_[lane] = offers_;
        }
    }

    /// Passes frames to the kernel, which takes some of them. `full`: it has no room.
    void hand_over(bool full) {
        const std::span<const CanFrame> next = transmitter_.next(now_);
        if (next.empty()) {
            return;
        }
        RC_ASSERT(controller_.empty());
        const std::size_t lane = next[0].id >> 8;
        const std::uint32_t number = number_of(next[0]);
        RC_ASSERT(number == newest_[lane]);
        RC_ASSERT(now_ - offered_at_[number] < CanTransmitter::kMostWait);
        Progress& progress = latest_[lane];
        const std::size_t gone = progress.number == number ? progress.parts : 0;
        RC_ASSERT(proven_ || gone > 0 || next.size() == 1U);
        for (std::size_t place = 0; place < next.size(); ++place) {
            RC_ASSERT(next[place].id == (lane << 8 | (gone + place)));
            RC_ASSERT(number_of(next[place]) == number);
        }
        if (full) {
            transmitter_.refused_full(now_);
            return;
        }
        const auto taken = *rc::gen::inRange<std::size_t>(1, next.size() + 1);
        controller_.assign(next.begin(), next.begin() + static_cast<std::ptrdiff_t>(taken));
        progress = {.number = number, .parts = gone + taken};
        transmitter_.handed(taken, now_);
    }

    /// One of the frames that the controller holds has left, in any order.
    void confirm() {
        if (!controller_.empty()) {
            const auto place = *rc::gen::inRange<std::size_t>(0, controller_.size());
            transmitter_.confirmed(controller_[place], now_);
            controller_.erase(controller_.begin() + static_cast<std::ptrdiff_t>(place));
            proven_ = true;
        }
    }
    void down() {
        transmitter_.went_down();
        controller_.clear();
        proven_ = false;
    }
    void up() { transmitter_.came_up(now_); }
    void bus_off() {
        transmitter_.bus_off(now_);
        proven_ = false;
    }
    void restart() {
        transmitter_.restarted(now_);
        controller_.clear();
    }

    void check_that_it_recovers() {
        up();
        restart();
        now_ += 1s;
        offer();
        hand_over(false);
        RC_ASSERT(!controller_.empty());
        RC_ASSERT(transmitter_.state() == CanBusState::ready);
    }

  private:
    struct Progress {
        std::uint32_t number = 0;
        std::size_t parts = 0;
    };

    static std::uint32_t number_of(const CanFrame& frame) {
        std::uint32_t number = 0;
        for (std::size_t byte = 0; byte < 4; ++byte) {
            number |= static_cast<std::uint32_t>(frame.data[byte]) << (8 * byte);
        }
        return number;
    }

    CanCounts counts_;
    CanTransmitter transmitter_{counts_, true};
    Instant now_ = Instant(1h);
    std::uint32_t offers_ = 0;
    bool proven_ = false;  ///< a frame was confirmed since the latest outage
    std::vector<CanFrame> controller_;
    std::map<std::uint32_t, Instant> offered_at_;
    std::map<std::size_t, std::uint32_t> newest_;
    std::map<std::size_t, Progress> latest_;
};

RC_GTEST_PROP(CanTransmitterProperty,
              OneSnapshotInFlightInOrderNeverOldAlwaysOfTheNewestSnapshotWhateverHappens, ()) {
    Promises promises;
    const auto steps = *rc::gen::container<std::vector<int>>(400, rc::gen::inRange<int>(0, 64));
    for (const int step : steps) {
        promises.advance(*rc::gen::element<Duration>(0us, 100us, 1ms, 7ms, 30ms, 60ms));
        if (step < 20) {
            promises.offer();
        } else if (step < 40) {
            promises.hand_over(step == 20);
        } else if (step < 56) {
            promises.confirm();
        } else if (step < 57) {
            promises.down();
        } else if (step < 60) {
            promises.up();
        } else if (step < 61) {
            promises.bus_off();
        } else {
            promises.restart();
        }
    }
    promises.check_that_it_recovers();
}

}  // namespace
}  // namespace tribus::can_transmitter_property_test
