#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tribus {

/// Why the frames of an input count, or do not. The numbers are those that go over a CAN bus.
enum class LinkCause : std::uint8_t {
    good,
    never_seen,        ///< not one byte since the start
    wire_silent,       ///< no bytes any more
    garbled,           ///< bytes, but no frames
    radio_lost,        ///< frames, but the receiver has lost its transmitter
    stale,             ///< frames that do not change any more
    implausible,       ///< frames with values that no transmitter sends
    channels_missing,  ///< frames without a channel that was there, or without any
};
inline constexpr std::size_t kLinkCauseCount = 8;

/// For people, as "radio lost".
constexpr std::string_view name_of(LinkCause cause) {
    constexpr std::array<std::string_view, kLinkCauseCount> kNames{
        "good",       "never seen", "wire silent", "garbled",
        "radio lost", "stale",      "implausible", "channels missing"};
    return kNames[static_cast<std::size_t>(cause)];
}

/// How it shows that a radio link is down.
enum class RadioLossSign : std::uint8_t {
    none,
    failsafe_flag,
    value_rule,
    frame_lost_run,    ///< nothing but frames marked frame-lost
    frame_lost_ratio,  ///< too many of them among the good ones
};

}  // namespace tribus
