#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/time.h"

/// Parts of a live view in a terminal. Pure.
namespace tribus {

struct ScreenStyle {
    std::size_t columns = 80;
    std::size_t rows = 24;
    bool unicode = true;
    bool colour = true;
};

namespace screen {

inline constexpr std::string_view kReset = "\x1b[0m";
inline constexpr std::string_view kGreen = "\x1b[32m";
inline constexpr std::string_view kYellow = "\x1b[33m";
inline constexpr std::string_view kRed = "\x1b[31m";
inline constexpr std::string_view kDim = "\x1b[2m";
inline constexpr std::string_view kBold = "\x1b[1m";
inline constexpr std::string_view kReverse = "\x1b[7m";
/// The end of each line: erases the rest of the old line.
inline constexpr std::string_view kEraseRest = "\x1b[K\r\n";

/// Length in bytes of the control character at the beginning of `text`, which a terminal would
/// obey: below blank, delete, or U+0080 to U+009F. 0 if there is none.
std::size_t control_length(std::string_view text);

/// Shows that something was cut off.
std::string_view cut_mark(const ScreenStyle& style);

/// One line of text that knows its visible width, so that it can be cut without breaking a colour
/// sequence. Where more than blanks is cut off, the line ends with the mark. Control characters
/// become '?', because names may come from anywhere.
class Line {
  public:
    explicit Line(const ScreenStyle& style) : style_(style) {}

    /// Appends text as far as it fits, in a colour unless the style has none.
    void add(std::string_view text, std::string_view colour = {});
    std::size_t width() const { return width_; }
    std::string take() { return std::move(text_); }

  private:
    void mark_cut();

    const ScreenStyle& style_;
    std::string text_;
    std::size_t width_ = 0;
    std::size_t last_at_ = 0;  ///< place in `text_` of the last visible character
    std::size_t last_length_ = 0;
    bool cut_ = false;
};

/// A bar with a scale of 900 to 2100 us, filled from its centre to the value. `width` is at least
/// 3.
std::string bar(std::optional<double> pulse_us, std::size_t width, bool unicode);

/// Ends and centre of the scale in us, to be printed above or below a bar; blank if there is no
/// room.
std::string bar_scale(std::size_t width);

/// "1500 ", or a dash without a value.
std::string pulse_number(std::optional<double> pulse_us);
inline constexpr std::size_t kPulseNumberWidth = 5;

}  // namespace screen

/// "41 us", "98 ms": at most three digits.
std::string short_duration(Duration duration);

}  // namespace tribus
