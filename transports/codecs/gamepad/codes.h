#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// The kernel's names of axes and buttons that a configuration may have
/// (linux/input-event-codes.h). Pure.
namespace tribus {

/// The code behind a name such as "ABS_X" or "BTN_SOUTH"; nothing for any other name.
std::optional<std::uint16_t> gamepad_axis_code(std::string_view name);
std::optional<std::uint16_t> gamepad_button_code(std::string_view name);

/// The name of a code; empty if a configuration cannot name it.
std::string_view gamepad_axis_name(std::uint16_t code);
std::string gamepad_button_name(std::uint16_t code);

}  // namespace tribus
