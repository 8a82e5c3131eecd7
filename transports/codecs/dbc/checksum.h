#pragma once

#include <cstdint>
#include <span>

#include "transports/codecs/dbc/map.h"

namespace tribus {

/// The checksum of a whole frame. The present content of the checksum's own bytes does not count.
/// Pure and reentrant; no heap.
std::uint64_t dbc_checksum(const DbcChecksum& checksum, std::uint32_t id,
                           std::span<const std::uint8_t> data);

}  // namespace tribus
