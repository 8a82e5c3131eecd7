#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"

/// Writes recorded bytes and CAN frames as text, in the formats that `parse_recording` reads. Pure
/// and reentrant.
namespace tribus {

/// First line of every timed recording. It marks the kind, whatever the numbers.
inline constexpr std::string_view kTimedHeading = "# t_us  bytes\n";

/// Appends `20 40 dc 05` and a line end.
void append_hex_line(std::string& text, std::span<const std::uint8_t> bytes);

/// Appends the start, rounded to whole microseconds as all readers expect, then the bytes as above.
void append_timed_line(std::string& text, Duration start, std::span<const std::uint8_t> bytes);

/// The same, with `!` after each damaged byte. `damaged` has one mark for each byte.
void append_timed_line(std::string& text, Duration start, std::span<const std::uint8_t> bytes,
                       const std::vector<bool>& damaged);

/// Appends the heading of a candump log that gives the time of its zero.
void append_candump_zero(std::string& text, Duration zero);

/// Appends `(0000000001.249713) can0 123#1122` and a line end, with the time rounded to whole
/// microseconds. `at` must not be negative.
void append_candump_line(std::string& text, Duration at, std::string_view interface,
                         const CanFrame& frame);

}  // namespace tribus
