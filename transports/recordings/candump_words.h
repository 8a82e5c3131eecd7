#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "core/can_frame.h"
#include "core/time.h"
#include "transports/recordings/text.h"

/// The words of a line of candump. Pure.
namespace tribus {

inline constexpr std::string_view kWhatALineIs =
    "; a line is (1436509052.249713) can0 123#1122, as candump -L and candump -l write it";

/// An error in a line, and its place: a column, from 1.
struct CandumpFlaw {
    std::size_t at = 0;
    std::string text;
};

/// Reads `(1436509052.249713)`: seconds with up to 9 decimals.
std::optional<Duration> parse_candump_time(std::string_view word);

/// Whether it is a line of candump's screen: `can0  123   [2]  11 22`.
bool is_candump_screen_line(std::string_view line);

/// Reads the frame that begins with `word`, behind the interface: `123#1122`, or `123   [2]  11 22`
/// as on the screen. Nothing for an error frame of the kernel.
tl::expected<std::optional<CanFrame>, CandumpFlaw> parse_candump_frame(
    recording_text::Tokens& tokens, const recording_text::Token& word);

}  // namespace tribus
