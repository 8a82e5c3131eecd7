#pragma once

#include <cstdint>
#include <span>

#include "transports/codecs/dbc/map.h"

namespace tribus {

/// The checksum of a whole frame, whatever stands in the checksum's own bytes. Pure and reentrant;
/// no heap.
std::uint64_t dbc_checksum(const DbcChecksum& checksum, std::uint32_t id,
                           std::span<const std::uint8_t> data);

}  // namespace tribus
