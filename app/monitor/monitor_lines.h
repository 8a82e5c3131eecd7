#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "app/cli/screen_parts.h"
#include "app/client/status_fields.h"
#include "core/time.h"

/// The lines of the monitor for inputs, outputs, ports, sensor buses and values. Pure.
namespace tribus::monitor {

using status_fields::Json;

/// Columns of a line of an input or output.
inline constexpr std::size_t kNameWidth = 12;
inline constexpr std::size_t kProtocolWidth = 8;
inline constexpr std::size_t kStateWidth = 22;

/// A duration in microseconds; 0 if the field is missing.
Duration us_of(const Json& object, const char* key);
/// Colour sequence for the `state` of an input or output.
std::string_view colour_of(const std::string& state);
/// The state of an input or output in words.
std::string input_state(const Json& input);
std::string output_state(const Json& output);
/// "waits for receiver: never seen". Empty for an output in control.
std::string awaited_text(const Json& output);

/// `old`: the figures are out of date and shown dimmed.
std::string input_line(const Json& input, bool selected, bool old, const ScreenStyle& style);
std::string output_line(const Json& output, bool selected, bool old, const ScreenStyle& style);
std::string port_line(const Json& port, const ScreenStyle& style);
std::string bus_line(const Json& bus, const ScreenStyle& style);
std::string value_line(const Json& value, const ScreenStyle& style);

}  // namespace tribus::monitor
