#pragma once

#include <string>
#include <string_view>

#include "app/monitor_fields.h"
#include "app/screen_parts.h"
#include "core/time.h"

/// How a monitor shows each thing of a status in one line. Pure.
namespace tribus::monitor {

/// A number of microseconds; 0 where there is none.
Duration us_of(const Json& object, const char* key);
std::string_view colour_of(const std::string& state);
/// What state an input or output is in, in words.
std::string input_state(const Json& input);
std::string output_state(const Json& output);

/// `old`: the figures are none of now.
std::string input_line(const Json& input, bool selected, bool old, const ScreenStyle& style);
std::string output_line(const Json& output, bool selected, bool old, const ScreenStyle& style);
std::string port_line(const Json& port, const ScreenStyle& style);
std::string bus_line(const Json& bus, const ScreenStyle& style);
std::string value_line(const Json& value, const ScreenStyle& style);

}  // namespace tribus::monitor
