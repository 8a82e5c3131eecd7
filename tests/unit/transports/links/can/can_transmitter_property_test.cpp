#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
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

    /// Passes a frame to the kernel. `full`: the kernel has no room.
    void hand_over(bool full) {
        const CanFrame* next = transmitter_.next(now_);
        if (next == nullptr) {
            return;
        }
        RC_ASSERT(controller_.empty());
        const std::size_t lane = next->id >> 8;
        const std::size_t part = next->id & 0xFF;
        std::uint32_t number = 0;
        for (std::size_t byte = 0; byte < 4; ++byte) {
            number |= static_cast<std::uint32_t>(next->data[byte]) << (8 * byte);
        }
        RC_ASSERT(number == newest_[lane]);
        RC_ASSERT(now_ - offered_at_[number] < CanTransmitter::kMostWait);
        RC_ASSERT(part == (latest_[lane].number == number ? latest_[lane].parts : 0U));
        if (full) {
            transmitter_.refused_full(now_);
            return;
        }
        latest_[lane] = {.number = number, .parts = part + 1};
        controller_.push_back(*next);
        transmitter_.handed(now_);
    }

    void confirm() {
        if (!controller_.empty()) {
            controller_.pop_back();
            transmitter_.confirmed();
        }
    }
    void down() {
        transmitter_.went_down();
        controller_.clear();
    }
    void up() { transmitter_.came_up(now_); }
    void bus_off() { transmitter_.bus_off(now_); }
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
        RC_ASSERT(controller_.size() == 1U);
        RC_ASSERT(transmitter_.state() == CanBusState::ready);
    }

  private:
    struct Progress {
        std::uint32_t number = 0;
        std::size_t parts = 0;
    };

    CanCounts counts_;
    CanTransmitter transmitter_{counts_};
    Instant now_ = Instant(1h);
    std::uint32_t offers_ = 0;
    std::vector<CanFrame> controller_;
    std::map<std::uint32_t, Instant> offered_at_;
    std::map<std::size_t, std::uint32_t> newest_;
    std::map<std::size_t, Progress> latest_;
};

RC_GTEST_PROP(CanTransmitterProperty,
              OneFrameInFlightInOrderNeverOldAlwaysOfTheNewestSnapshotWhateverHappens, ()) {
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
