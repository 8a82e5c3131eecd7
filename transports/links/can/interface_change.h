#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "transports/links/unique_fd.h"

namespace tribus {

/// What the kernel tells of a network interface that has changed (rtnetlink).
struct InterfaceChange {
    std::uint32_t index = 0;
    std::string_view name{};  ///< part of the message
    bool gone = false;
    bool up = false;
    bool running = false;  ///< up, and with a carrier
};

/// Reads an RTM_NEWLINK or RTM_DELLINK message, whose end may be missing. Nothing for another one.
/// Pure and reentrant, no heap.
std::optional<InterfaceChange> parse_interface_change(std::span<const std::byte> message);

/// A socket that receives such a message when a network interface has changed. Invalid, with
/// errno, if there is none.
UniqueFd watch_interfaces();
/// From now on only of that interface, if the kernel can filter.
void watch_only(const UniqueFd& changes, std::uint32_t index);

}  // namespace tribus
