#pragma once

#include <cstdint>

namespace tribus {

/// The form in which a link carries a protocol.
enum class WireShape : std::uint8_t { bytes, can_frames };

}  // namespace tribus
