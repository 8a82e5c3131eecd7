#pragma once

#include <cstdint>

namespace tribus {

/// What the frames of a protocol are on the wire.
enum class WireShape : std::uint8_t { bytes, can_frames };

}  // namespace tribus
