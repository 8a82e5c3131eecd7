#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/time.h"
#include "transports/codecs/ibus_sensor.h"

namespace tribus {

/// Events of one wire since start. Only ever incremented.
struct EchoCounts {
    std::uint64_t heard = 0;  ///< own frames that came back as they were sent
    /// Own frames of which nothing came back: another wire for each direction, or none at all.
    std::uint64_t unheard = 0;
    /// Own frames that came back otherwise, or in part: somebody else spoke at the same time.
    std::uint64_t collisions = 0;
};

/// On one wire for both directions a sender hears itself. What comes back is told by its count, not
/// by its content, for a reply may be the same bytes as its request (docs/protocols/ibus.md,
/// "Sensor bus: wire"); the content is only compared. Pure; thread-bound.
class EchoCanceller {
  public:
    /// A frame of at most kLongestSensorFrame bytes was handed over at `now`.
    void sent(std::span<const std::uint8_t> frame, Instant now);
    /// Takes what is echo off the front of `bytes`, which were read at `now`.
    void cancel(std::span<const std::uint8_t>& bytes, Instant now);
    /// A byte came at `now` that the line damaged. True: it was echo.
    bool cancel_damaged(Instant now);
    /// Counts a frame whose echo is overdue at `now`.
    void expire(Instant now);

    const EchoCounts& counts() const { return counts_; }

  private:
    void finish();

    std::array<std::uint8_t, kLongestSensorFrame> frame_{};
    std::size_t length_ = 0;
    std::size_t heard_ = 0;
    bool differs_ = false;
    Instant until_{};
    EchoCounts counts_;
};

}  // namespace tribus
