#pragma once

#include <cstdint>
#include <span>

#include "transports/links/link.h"

namespace tribus {

/// Undoes the marks that a Linux terminal line puts into its bytes under INPCK and PARMRK
/// (docs/protocols/sbus.md, "Serial port: parity"): FF FF is one good byte FF; FF 00 xx is a byte
/// xx with a parity or framing error, and FF 00 00 is also what a break looks like. Keeps its place
/// from one read to the next, since the kernel may cut anywhere. Pure; thread-bound.
class ParityMarks {
  public:
    /// Appends what `raw` means to `reception`: at most one byte for each raw byte. Promises
    /// nothing about raw bytes beyond the room that `reception` has.
    void take(std::span<const std::uint8_t> raw, Reception& reception);

  private:
    enum class Place : std::uint8_t { plain, after_mark, before_damaged };

    /// Returns the rest.
    static std::span<const std::uint8_t> take_until_mark(std::span<const std::uint8_t> raw,
                                                         Reception& reception);
    void take_byte(std::uint8_t byte, Reception& reception);

    Place place_ = Place::plain;
};

}  // namespace tribus
