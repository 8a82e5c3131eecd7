#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/time.h"
#include "transports/links/can/can_link.h"
#include "transports/links/link.h"

namespace tribus {

/// Faults of a bad line. Probabilities from 0 to 1.
struct FaultSettings {
    double lose_byte = 0;
    double flip_bit = 0;     ///< one bit of a byte is read wrong without an error
    double add_byte = 0;     ///< a byte of noise before a byte
    double damage_byte = 0;  ///< one bit is read wrong with a parity error
    double drop_frame = 0;   ///< a whole burst, one read or one write, is lost
    double cut_frame = 0;    ///< a burst lacks some bytes at its beginning or its end
    Duration most_delay{};   ///< bursts come late by 0 up to this
    /// If bytes are lost or added: 1 up to this many in a row.
    unsigned most_in_a_row = 1;
};

/// Random numbers from a seed: the same on every machine. Pure. Thread-bound.
class FaultRandom {
  public:
    explicit FaultRandom(std::uint64_t seed) : state_(seed) {}

    std::uint64_t next();
    bool happens(double probability);
    /// From 0 up to `most`.
    Duration delay(Duration most);

  private:
    std::uint64_t state_;
};

/// Makes faults from a seed: the same seed and the same calls give the same faults on every
/// machine. Pure: no clock, no heap. Thread-bound.
class FaultInjector {
  public:
    FaultInjector(const FaultSettings& settings, std::uint64_t seed)
        : settings_(settings), random_(seed) {}

    /// Appends `in` to `out` with faults of single bytes. Bytes for which `out` has no room are
    /// lost.
    void apply(std::span<const std::uint8_t> in, Reception& out);
    /// The same, and keeps the error marks of `in`.
    void apply(const Reception& in, Reception& out);

    /// Delay of the next burst.
    Duration next_delay() { return random_.delay(settings_.most_delay); }
    /// Whether the next burst is lost as a whole.
    bool drop_frame() { return random_.happens(settings_.drop_frame); }

  private:
    /// The part of a burst that a cut leaves.
    struct Part {
        std::size_t begin = 0;
        std::size_t end = 0;
    };
    Part cut(std::size_t count);
    void apply_byte(std::uint8_t byte, bool damaged, Reception& out);
    unsigned in_a_row();

    FaultSettings settings_;
    FaultRandom random_;
    unsigned still_to_lose_ = 0;
};

/// Faults of a bad bus, or of gateways and drivers. Probabilities from 0 to 1 for each frame.
struct CanFaultSettings {
    double lose_frame = 0;
    double duplicate_frame = 0;
    double flip_bit = 0;    ///< one bit of its data is read wrong and the bus does not notice
    double late_frame = 0;  ///< the frame arrives later than the frames around it
    Duration most_delay{};  ///< of a late frame: from 0 up to this
};

/// The same for CAN frames.
class CanFaultInjector {
  public:
    CanFaultInjector(const CanFaultSettings& settings, std::uint64_t seed)
        : settings_(settings), random_(seed) {}

    /// Appends the frame to `out`: not at all, once, or twice. Frames for which `out` has no room
    /// are lost. A late frame has a later `at`, so `out` may not be in order of arrival.
    void apply(const ReceivedCanFrame& in, CanReception& out);

  private:
    CanFaultSettings settings_;
    FaultRandom random_;
};

/// Adds faults to both directions of another link, which must outlive it. The caller applies
/// delays. A written byte cannot carry a parity error, only the wrong bit. Thread-bound.
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
