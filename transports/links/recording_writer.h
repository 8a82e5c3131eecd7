#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"

/// Recorded bytes and CAN frames as text, in the forms that `parse_recording` reads. Pure.
namespace tribus {

/// First line of every timed recording: tells its kind, whatever numbers follow.
inline constexpr std::string_view kTimedHeading = "# t_us  bytes\n";

/// Adds `20 40 dc 05` and a line end.
void append_hex_line(std::string& text, std::span<const std::uint8_t> bytes);

/// Adds the start, rounded to whole microseconds as every reader of the form expects, then the
/// bytes as above.
void append_timed_line(std::string& text, Duration start, std::span<const std::uint8_t> bytes);

/// The same, with a `!` behind each byte that came with a parity or framing error; as many marks as
/// bytes.
void append_timed_line(std::string& text, Duration start, std::span<const std::uint8_t> bytes,
                       const std::vector<bool>& damaged);

/// Heading of a log of candump whose zero is not the time of its first line but this one.
void append_candump_zero(std::string& text, Duration zero);

/// Adds `(0000000001.249713) can0 123#1122` and a line end, the time rounded to whole microseconds.
/// `at` is not negative.
void append_candump_line(std::string& text, Duration at, std::string_view interface,
                         const CanFrame& frame);

}  // namespace tribus
