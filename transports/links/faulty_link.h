#pragma once

#include <cstdint>
#include <span>

#include "core/time.h"
#include "transports/links/link.h"

namespace tribus {

/// What goes wrong on a bad wire. Probabilities from 0 to 1.
struct FaultSettings {
    double lose_byte = 0;
    double flip_bit = 0;     ///< one bit of a byte reads wrong and nobody notices
    double add_byte = 0;     ///< a byte of noise before a byte
    double damage_byte = 0;  ///< one bit reads wrong and the receiver sees a parity error
    double drop_frame = 0;   ///< a whole burst, one read or one write, is gone
    Duration most_delay{};   ///< bursts come late by nothing up to this
};

/// Makes faults from a seed: the same seed and the same calls give the same faults on every
/// machine. Pure: no clock, no heap. Thread-bound.
class FaultInjector {
  public:
    FaultInjector(const FaultSettings& settings, std::uint64_t seed)
        : settings_(settings), state_(seed) {}

    /// Appends `in` with faults of single bytes to `out`; what `out` has no room for is lost.
    void apply(std::span<const std::uint8_t> in, Reception& out);
    /// As above, and keeps the damage that `in` has already.
    void apply(const Reception& in, Reception& out);

    /// How late the next burst is.
    Duration next_delay();
    /// Whether the next burst is gone as a whole.
    bool drop_frame() { return happens(settings_.drop_frame); }

  private:
    void apply_byte(std::uint8_t byte, bool damaged, Reception& out);
    std::uint8_t random_bit();
    bool happens(double probability);
    std::uint64_t next();

    FaultSettings settings_;
    std::uint64_t state_;
};

/// Puts faults on both directions of another link, which must outlive it. Delays are the
/// caller's, who has the time; a written byte cannot carry a parity error, only its wrong bit.
class FaultyLink : public ByteLink {
  public:
    FaultyLink(ByteLink& link, const FaultSettings& settings, std::uint64_t seed)
        : link_(link), injector_(settings, seed) {}

    ReadStatus read(Reception& reception) override;
    WriteStatus write(std::span<const std::uint8_t> frame) override;
    int descriptor() const override { return link_.descriptor(); }

  private:
    ByteLink& link_;
    FaultInjector injector_;
};

}  // namespace tribus
