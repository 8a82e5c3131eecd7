#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/time.h"
#include "transports/links/can_link.h"
#include "transports/links/link.h"

namespace tribus {

/// What goes wrong on a bad wire. Probabilities from 0 to 1.
struct FaultSettings {
    double lose_byte = 0;
    double flip_bit = 0;     ///< one bit of a byte reads wrong and nobody notices
    double add_byte = 0;     ///< a byte of noise before a byte
    double damage_byte = 0;  ///< one bit reads wrong and the receiver sees a parity error
    double drop_frame = 0;   ///< a whole burst, one read or one write, is gone
    double cut_frame = 0;    ///< a burst lacks some bytes at its beginning or at its end
    Duration most_delay{};   ///< bursts come late by nothing up to this
    /// Where a byte is lost or added, one up to so many in a row are.
    unsigned most_in_a_row = 1;
};

/// Chances from a seed: the same on every machine. Pure. Thread-bound.
class FaultDice {
  public:
    explicit FaultDice(std::uint64_t seed) : state_(seed) {}

    std::uint64_t next();
    bool happens(double probability);
    /// Nothing up to this.
    Duration delay(Duration most);

  private:
    std::uint64_t state_;
};

/// Makes faults from a seed: the same seed and the same calls give the same faults on every
/// machine. Pure: no clock, no heap. Thread-bound.
class FaultInjector {
  public:
    FaultInjector(const FaultSettings& settings, std::uint64_t seed)
        : settings_(settings), dice_(seed) {}

    /// Appends `in` with faults of single bytes to `out`; what `out` has no room for is lost.
    void apply(std::span<const std::uint8_t> in, Reception& out);
    /// As above, and keeps the damage that `in` has already.
    void apply(const Reception& in, Reception& out);

    /// How late the next burst is.
    Duration next_delay() { return dice_.delay(settings_.most_delay); }
    /// Whether the next burst is gone as a whole.
    bool drop_frame() { return dice_.happens(settings_.drop_frame); }

  private:
    /// What a cut leaves of a burst of `count` bytes.
    struct Part {
        std::size_t begin = 0;
        std::size_t end = 0;
    };
    Part cut(std::size_t count);
    void apply_byte(std::uint8_t byte, bool damaged, Reception& out);
    unsigned in_a_row();

    FaultSettings settings_;
    FaultDice dice_;
    unsigned still_to_lose_ = 0;
};

/// What goes wrong on a bad bus, or in the gateways and drivers on the way. Probabilities from 0 to
/// 1, each for one frame.
struct CanFaultSettings {
    double lose_frame = 0;
    double duplicate_frame = 0;
    double flip_bit = 0;    ///< one bit of its data reads wrong and the bus does not notice
    double late_frame = 0;  ///< it comes later than the frames around it
    Duration most_delay{};  ///< of a late frame: by nothing up to this
};

/// The same for CAN frames.
class CanFaultInjector {
  public:
    CanFaultInjector(const CanFaultSettings& settings, std::uint64_t seed)
        : settings_(settings), dice_(seed) {}

    /// Appends the frame to `out`: not at all, once, or twice; what `out` has no room for is lost.
    /// A late one has a later `at`, so they may no longer stand in the order of arrival.
    void apply(const ReceivedCanFrame& in, CanReception& out);

  private:
    CanFaultSettings settings_;
    FaultDice dice_;
};

/// Puts faults on both directions of another link, which must outlive it. Delays are the
/// caller's, who has the time; a written byte cannot carry a parity error, only its wrong bit.
class FaultyLink : public ByteLink {
  public:
    FaultyLink(ByteLink& link, const FaultSettings& settings, std::uint64_t seed)
        : link_(link), injector_(settings, seed) {}

    ReadStatus read(Reception& reception) override;
    WriteStatus write(std::span<const std::uint8_t> frame) override;
    void discard_unread() override { link_.discard_unread(); }
    int descriptor() const override { return link_.descriptor(); }

  private:
    ByteLink& link_;
    FaultInjector injector_;
};

}  // namespace tribus
