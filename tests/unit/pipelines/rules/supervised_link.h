#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "pipelines/rules/link_supervisor.h"

/// A bench for tests of the supervision of a link.
namespace tribus::test::link {

using namespace std::chrono_literals;

inline constexpr Duration kInterval = 7ms;
inline constexpr Pulse kRawZero = Pulse::from_microseconds(880);

inline Pulse us(std::int64_t microseconds) {
    return Pulse::from_microseconds(microseconds);
}
inline Instant at(Duration since_start) {
    return Instant(since_start);
}

/// Channels of a receiver with 16 channels: sticks around the centre.
inline ChannelFrame sticks(std::int64_t third = 1200) {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < 16; ++channel) {
        frame.set(channel, us(1500));
    }
    frame.set(2, us(third));
    frame.frame_lost = false;
    frame.failsafe = false;
    return frame;
}
inline ChannelFrame frame_lost(ChannelFrame frame) {
    frame.frame_lost = true;
    return frame;
}
inline ChannelFrame failsafe(ChannelFrame frame) {
    frame.frame_lost = true;
    frame.failsafe = true;
    return frame;
}
inline ChannelFrame zeros() {
    ChannelFrame frame = sticks();
    for (std::size_t channel = 0; channel < 16; ++channel) {
        frame.set(channel, kRawZero);
    }
    return frame;
}

/// A supervised link with one frame every 7 ms from 0 ms on.
class Link {
  public:
    explicit Link(SupervisionSettings settings = {}) : supervisor_(std::move(settings)) {}

    /// Sends the frames `make(n)`, with n from 0, until `until`.
    template <class Make>
    Link& frames(Duration until, Make make) {
        for (std::int64_t n = 0; next_ < at(until); next_ += kInterval, ++n) {
            ChannelFrame frame = make(n);
            frame.received = next_;
            supervisor_.bytes_came(next_);
            supervisor_.take(frame, next_);
        }
        return *this;
    }
    Link& same(Duration until, const ChannelFrame& frame) {
        return frames(until, [&](std::int64_t) { return frame; });
    }
    Link& moving(Duration until) {
        return frames(until, [](std::int64_t n) { return sticks(1200 + n % 100); });
    }
    Link& bytes(Duration until) {
        for (; next_ < at(until); next_ += kInterval) {
            supervisor_.bytes_came(next_);
        }
        return *this;
    }
    Link& silence(Duration until) {
        next_ = at(until);
        return *this;
    }
    LinkState state(Duration when) const { return supervisor_.state(at(when)); }
    LinkCause cause(Duration when) const { return state(when).cause; }
    const LinkSupervisor& supervisor() const { return supervisor_; }
    LinkSupervisor& supervisor() { return supervisor_; }

  private:
    LinkSupervisor supervisor_;
    Instant next_{};
};

}  // namespace tribus::test::link
