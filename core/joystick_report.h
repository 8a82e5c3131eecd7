#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

/// The report of a joystick, as EdgeTX sends it over USB: three bytes of buttons, the first one in
/// the lowest bit, then eight axes of two bytes, the low one first (docs/protocols/joystick.md).
/// Pure and reentrant.
namespace tribus {

inline constexpr std::array<std::string_view, 8> kJoystickAxes{
    "ABS_X", "ABS_Y", "ABS_Z", "ABS_RX", "ABS_RY", "ABS_RZ", "ABS_THROTTLE", "ABS_RUDDER"};
inline constexpr std::size_t kJoystickButtons = 24;
inline constexpr std::uint16_t kJoystickMost = 2047;
inline constexpr std::uint16_t kJoystickCentre = 1024;
inline constexpr std::size_t kJoystickButtonBytes = kJoystickButtons / 8;
inline constexpr std::size_t kJoystickReportBytes = kJoystickButtonBytes + 2 * kJoystickAxes.size();

inline std::uint16_t joystick_axis(std::span<const std::uint8_t> report, std::size_t axis) {
    const std::size_t at = kJoystickButtonBytes + 2 * axis;
    return static_cast<std::uint16_t>(report[at] | report[at + 1] << 8);
}
inline void set_joystick_axis(std::span<std::uint8_t> report, std::size_t axis,
                              std::uint16_t value) {
    const std::size_t at = kJoystickButtonBytes + 2 * axis;
    report[at] = static_cast<std::uint8_t>(value);
    report[at + 1] = static_cast<std::uint8_t>(value >> 8U);
}
inline bool joystick_button(std::span<const std::uint8_t> report, std::size_t button) {
    return (report[button / 8] >> button % 8 & 1U) != 0;
}

}  // namespace tribus
