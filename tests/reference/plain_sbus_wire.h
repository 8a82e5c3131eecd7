#pragma once

#include <cstddef>
#include <cstdint>

/// Places and values in a frame of SBUS that both files of its plain form know.
namespace tribus::reference::plain_sbus_wire {

inline constexpr std::uint8_t kHeader = 0x0F;
inline constexpr std::size_t kFlagsAt = 23;
inline constexpr std::size_t kFooterAt = 24;

}  // namespace tribus::reference::plain_sbus_wire
