#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/line_settings.h"
#include "core/time.h"

namespace tribus {

/// Draws bytes as the level on a serial wire: a Value Change Dump (IEEE 1364) with one signal
/// `wire`, for logic analyser software.
///
/// Start bit, eight data bits with the least significant first, parity, stop bits, at exact bit
/// times: each edge is rounded separately, so errors do not accumulate. Idle is high, or low on an
/// inverted wire. Pure.
class Waveform {
  public:
    /// Time unit of the dump: less than 1/500 of the shortest bit, but coarse enough for programs
    /// that work sample by sample.
    static constexpr Duration kTimescale = std::chrono::nanoseconds(10);

    explicit Waveform(const LineSettings& line) : line_(line) {}

    /// Appends the header, with an idle wire from time 0. A reader must see one byte's time of idle
    /// wire before the first start bit; if `first_start`, the start of the first frame, is earlier,
    /// everything is moved back to that.
    void begin(std::string& dump, Duration first_start);

    /// Appends one frame without pauses between its bytes. A frame that starts while the previous
    /// one is still on the wire follows it at once; `delayed()` counts those that are late by one
    /// byte or more.
    void frame(std::string& dump, Duration start, std::span<const std::uint8_t> bytes);

    /// Appends one byte's time of idle wire.
    void end(std::string& dump) const;

    /// Number of frames that were late by a byte or more.
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
