#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/time.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"

namespace tribus {

/// Counters of one wire since the start. They never decrease.
struct EchoCounts {
    std::uint64_t returned = 0;  ///< own frames that came back as sent
    /// Own frames of which nothing came back: separate wires, or no wire.
    std::uint64_t missing = 0;
    /// Own frames that came back changed or incomplete: another device sent at the same time.
    std::uint64_t collisions = 0;
};

/// On one wire for both directions a sender receives its own bytes. They are recognised by their
/// count and not by their content, because a reply may equal its request (docs/protocols/ibus.md,
/// "Sensor bus: wire"). The content is only compared. Pure. Thread-bound.
class EchoCanceller {
  public:
    /// A frame of at most kLongestSensorFrame bytes was handed over at `now`.
    void sent(std::span<const std::uint8_t> frame, Instant now);
    /// Removes the echo from the front of `bytes`, which were read at `now`.
    void cancel(std::span<const std::uint8_t>& bytes, Instant now);
    /// A byte that was damaged on the line came at `now`. Returns true if it was echo.
    bool cancel_damaged(Instant now);
    /// Counts a frame whose echo is overdue at `now`.
    void expire(Instant now);

    const EchoCounts& counts() const { return counts_; }

  private:
    void finish();

    std::array<std::uint8_t, kLongestSensorFrame> frame_{};
    std::size_t length_ = 0;
    std::size_t echoed_ = 0;
    bool differs_ = false;
    Instant until_{};
    EchoCounts counts_;
};

}  // namespace tribus
