#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "tests/loopback/machine_stops.h"
#include "tests/loopback/wire.h"
#include "tests/reference/plain_sbus.h"

namespace tribus::test {

/// What came out of one SBUS output.
struct Testimony {
    std::uint64_t unmarked = 0;
    std::uint64_t marked = 0;      ///< marked frame-lost or failsafe
    std::uint64_t never_sent = 0;  ///< unmarked, with values that no whole frame had
    std::uint64_t too_old = 0;     ///< unmarked, and older than allowed
    std::uint64_t overtaken = 0;   ///< unmarked, although a newer frame had arrived long before
    Clock::duration oldest{};      ///< least age of the oldest unmarked frame
    std::uint64_t strays = 0;      ///< bytes that belong to no frame
};
std::string to_text(const Testimony& testimony);

/// Generates frames that can be told apart, and checks each frame that an SBUS output makes from
/// them: was it ever sent, how old is it, is it marked? It reads with the plain reference codec.
/// Ages are minimum ages: a busy witness makes them smaller, never larger. A machine that stops the
/// program between its look at an input and its write makes them larger, by no more than the time
/// of the stop, which is allowed.
class Witness {
  public:
    /// `line` tells the lines of one program apart. An unmarked frame may be as old as `most_age`.
    /// `stops` must outlive the witness.
    Witness(unsigned line, Clock::duration most_age, MachineStops& stops)
        : line_(line), most_age_(most_age), stops_(stops) {}

    /// Returns the next sixteen channels, each of which changes with each frame.
    Sticks next() { return sticks(next_); }
    /// The frame of `next` has been sent whole.
    void sent();
    /// The frame of `next` was sent, but damaged.
    void spoiled();
    /// From now on no frame may be older than the latest one that was sent.
    void want_the_newest() { oldest_wanted_ = next_ - 1; }

    /// Checks the frames that arrived since the last call.
    void listen(FarEnd& servos);
    /// Forgets the beginning of a frame that was cut off when the device was unplugged.
    void begin_anew();

    const Testimony& testimony() const { return testimony_; }
    /// Returns whether the latest frame was unmarked.
    bool in_control() const { return in_control_; }

  private:
    /// Number of frames in half a minute. An older frame counts as never sent.
    static constexpr std::size_t kRemembered = 4096;
    struct Arrival {
        std::uint64_t end = 0;
        Clock::time_point not_before{};
    };

    Sticks sticks(std::uint32_t number) const;
    std::optional<std::uint32_t> number_of(std::span<const std::uint16_t> raw) const;
    void judge(const DecodedFrame& frame);

    unsigned line_;
    Clock::duration most_age_;
    MachineStops& stops_;
    std::uint32_t next_ = 0;
    /// When the latest frames were sent; nothing for a damaged one.
    std::array<std::optional<Clock::time_point>, kRemembered> sent_{};
    std::optional<reference::PlainSbusDecoder> decoder_{std::in_place};
    /// Arrival times of bytes whose frame has not been checked yet.
    std::deque<Arrival> arrivals_;
    std::uint64_t bytes_ = 0;
    std::uint64_t strays_before_ = 0;
    Clock::time_point listened_{};
    Testimony testimony_;
    std::uint32_t oldest_wanted_ = 0;
    bool in_control_ = false;
};

}  // namespace tribus::test
