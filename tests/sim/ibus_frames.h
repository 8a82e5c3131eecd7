#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/channel_frame.h"

/// i.Bus frames of senders in a simulation.
namespace tribus::test {

/// Removes the absent channels from the frame in `bytes`, as in the frame of a sender with fewer
/// channels. Returns the length.
std::size_t shorten_ibus(std::span<std::uint8_t> bytes, const ChannelFrame& frame);

/// Returns whether damage made another frame of `sent` that no reader can refuse: its checksum is
/// right and its values are those of sticks. The checksum is a sum, so lost bytes with the same sum
/// as added ones do that: 74 33 lost and 34 73 added, in a world that was met.
bool damage_is_hidden(std::span<const std::uint8_t> received, std::span<const std::uint8_t> sent);

}  // namespace tribus::test
