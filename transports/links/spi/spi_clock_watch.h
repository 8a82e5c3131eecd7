#pragma once

#include <array>
#include <cstddef>

#include "core/time.h"

namespace tribus {

/// Sees by the durations of transfers that the clock of an SPI port has changed: a Raspberry Pi 4
/// scales it with the load. A late thread makes a transfer longer too, so the shortest of many
/// transfers raises the suspicion only, and zeros of two lengths decide. Pure; thread-bound.
class SpiClockWatch {
  public:
    /// A smaller change is none: receivers read a line that is so much off.
    static constexpr double kMostDrift = 0.015;

    /// `byte_time`: how long a byte lasts, as measured. It begins with a suspicion, for the clock
    /// may have changed since.
    explicit SpiClockWatch(Duration byte_time) : byte_time_(byte_time) {}

    /// A transfer took so long.
    void transferred(std::size_t bytes, Duration took);
    /// How many zeros should be sent now, in the pause between two frames. 0: none.
    std::size_t wanted_zeros() const;
    /// They took so long. Returns whether a byte is too long or too short now.
    bool compared(Duration took);

  private:
    static constexpr std::array<std::size_t, 2> kLengths{100, 300};
    static constexpr int kWindow = 32;
    static constexpr int kComparisons = 32;  ///< as many of each length

    Duration byte_time_;
    bool suspects_ = true;
    int compared_ = 0;
    std::array<Duration, 2> shortest_{Duration::max(), Duration::max()};
    Duration call_{};  ///< what a transfer takes beside its bytes
    int seen_ = 0;
    double least_ = 0;  ///< by which share a byte was longer, in this window
};

}  // namespace tribus
