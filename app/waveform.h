#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/line_settings.h"
#include "core/time.h"

namespace tribus {

/// Draws bytes as the level on a serial wire, as a Value Change Dump (IEEE 1364) with one signal
/// `wire`, for logic analysers' programs.
///
/// Start bit, eight data bits with the least significant first, parity, stop bits, at true bit
/// times: every edge is rounded by itself, so nothing adds up. Idle is high, low where the wire is
/// inverted. Pure.
class Waveform {
  public:
    /// One unit of the dump's time. Finer than 1/500 of the shortest bit, coarse enough for
    /// programs that work sample by sample.
    static constexpr Duration kTimescale = std::chrono::nanoseconds(10);

    explicit Waveform(const LineSettings& line) : line_(line) {}

    /// Adds the head of the dump, idle from the time 0 on. A reader needs to see the wire idle
    /// before it sees a start bit: where the first frame starts before one byte's time is over, all
    /// is moved to start there. `first_start` is when the first frame starts.
    void begin(std::string& dump, Duration first_start);

    /// Adds one frame, its bytes without a pause. A frame that starts before the one ahead has left
    /// the wire follows it at once; `delayed()` counts them if that is later by a byte or more.
    void frame(std::string& dump, Duration start, std::span<const std::uint8_t> bytes);

    /// Adds one byte's time of idle wire.
    void end(std::string& dump) const;

    std::uint64_t delayed() const { return delayed_; }

  private:
    void byte(std::string& dump, Duration frame_start, std::uint64_t bit, std::uint8_t value);
    void level(std::string& dump, Duration at, bool mark);

    LineSettings line_;
    Duration moved_{};
    Duration free_from_{};
    bool mark_ = true;
    std::uint64_t delayed_ = 0;
};

}  // namespace tribus
