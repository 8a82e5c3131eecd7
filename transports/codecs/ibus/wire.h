#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/channel_frame.h"
#include "transports/codecs/byte_sum.h"
#include "transports/codecs/wire_words.h"

/// Layout of an i.Bus frame (docs/protocols/ibus.md, "Servo frame"); only for its decoder and
/// encoder.
namespace tribus::ibus_wire {

inline constexpr std::size_t kSlotCount = 14;
inline constexpr std::size_t kSlotsAt = 2;
inline constexpr std::size_t kChecksumBytes = 2;
inline constexpr std::size_t kShortestFrame = 6;
inline constexpr std::size_t kLongestFrame = 32;
inline constexpr std::uint8_t kServoCommand = 0x40;
inline constexpr std::uint8_t kBetaflightTestCommand = 0x00;
inline constexpr std::uint16_t kChannelMask = 0x0FFF;
inline constexpr std::size_t kNibblesPerChannel = 3;
inline constexpr std::size_t kNibbleChannels = kChannelCount - kSlotCount;

static_assert(kSlotsAt + 2 * kSlotCount + kChecksumBytes == kLongestFrame);
static_assert(kNibbleChannels * kNibblesPerChannel <= kSlotCount);

using byte_sums::kGroupBytes;
using byte_sums::sum_by_words;
using byte_sums::total;
inline constexpr std::uint64_t kNibbles = 0xF000F000'F000F000;

}  // namespace tribus::ibus_wire
