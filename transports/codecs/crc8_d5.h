#pragma once

#include <cstdint>

#include "transports/codecs/crc.h"

/// CRC-8 of CRSF and GHST: polynomial D5, start 0, most significant bit first
/// (docs/protocols/crsf.md, "Frame").
namespace tribus {

using Crc8D5 = Crc<std::uint8_t, 0xD5>;

}  // namespace tribus
