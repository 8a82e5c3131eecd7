#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "tests/loopback/wire.h"
#include "tests/reference/plain_sbus.h"

namespace tribus::test {

/// What came out of one SBUS output.
struct Testimony {
    std::uint64_t unmarked = 0;
    std::uint64_t marked = 0;      ///< frame-lost or failsafe
    std::uint64_t never_sent = 0;  ///< unmarked, with values that no whole frame had
    std::uint64_t too_old = 0;     ///< unmarked, and older than it may be
    std::uint64_t overtaken = 0;   ///< unmarked, although a newer one had long been there
    Clock::duration oldest{};      ///< of the unmarked ones, at least
    std::uint64_t strays = 0;      ///< bytes of no frame
};
std::string to_text(const Testimony& testimony);

/// Stands around the program: gives out frames that can be told apart, and judges each one that an
/// SBUS output makes of them. Was it ever sent, how old is it, is it marked? Reads with the plain
/// reference codec. Ages are least ages: a busy machine makes them smaller, never larger.
class Witness {
  public:
    /// `line` tells the lines of one program apart; an unmarked frame may be as old as `most_age`.
    Witness(unsigned line, Clock::duration most_age) : line_(line), most_age_(most_age) {}

    /// Sixteen channels, each of which changes with each frame.
    Sticks next() { return sticks(next_); }
    /// The frame of `next` is on its way, whole.
    void sent();
    /// It went, but nobody can have it whole.
    void spoiled();
    /// Whatever comes from now on is of no older frame than the latest that was sent.
    void want_the_newest() { oldest_wanted_ = next_ - 1; }

    /// Judges what has arrived since the last call.
    void listen(FarEnd& servos);
    /// What was pulled in the middle of a frame does not go on.
    void begin_anew();

    const Testimony& testimony() const { return testimony_; }
    /// The latest frame was unmarked.
    bool in_control() const { return in_control_; }

  private:
    /// Frames, of half a minute; an older one counts as never sent.
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
    std::uint32_t next_ = 0;
    /// When the latest frames had been sent; nothing for a spoiled one.
    std::array<std::optional<Clock::time_point>, kRemembered> sent_{};
    std::optional<reference::PlainSbusDecoder> decoder_{std::in_place};
    /// Of bytes whose frame is not judged yet.
    std::deque<Arrival> arrivals_;
    std::uint64_t bytes_ = 0;
    std::uint64_t strays_before_ = 0;
    Clock::time_point listened_{};
    Testimony testimony_;
    std::uint32_t oldest_wanted_ = 0;
    bool in_control_ = false;
};

}  // namespace tribus::test
