#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/links/link.h"

namespace tribus {

/// Removes the marks that a Linux terminal line inserts with INPCK and PARMRK
/// (docs/protocols/sbus.md, "Serial port: parity"): FF FF is one good byte FF; FF 00 xx is a byte
/// xx with a parity or framing error, and FF 00 00 also a break. Keeps its state between reads,
/// since the kernel may cut anywhere. Pure; thread-bound.
class ParityMarks {
  public:
    /// The first `raw` bytes of an empty reception are as the kernel gave them: removes the marks
    /// from them, and counts the bytes that are left.
    void remove(std::size_t raw, Reception& reception);

  private:
    enum class Place : std::uint8_t { plain, after_mark, before_damaged };

    void take(std::span<const std::uint8_t> raw, Reception& reception);
    /// Returns the rest.
    static std::span<const std::uint8_t> take_until_mark(std::span<const std::uint8_t> raw,
                                                         Reception& reception);
    void take_byte(std::uint8_t byte, Reception& reception);

    Place place_ = Place::plain;
};

}  // namespace tribus
