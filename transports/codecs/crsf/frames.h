#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/codecs/framed_decoder.h"

namespace tribus {

/// Finds the frames of CRSF, whatever their type. What each of them means says the derived class.
class CrsfFrames : public FramedDecoder {
  protected:
    static std::span<const std::uint8_t> payload_of(std::span<const std::uint8_t> frame);

  private:
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const final;
    bool check_holds(std::span<const std::uint8_t> frame) const final;
};

}  // namespace tribus
