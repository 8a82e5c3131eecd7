#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "core/time.h"

/// Common parts of the readers of recordings: lines, words, numbers, errors. Pure and reentrant,
/// except for the classes, which are thread-bound.
namespace tribus::recording_text {

/// Follows a byte with a parity or framing error.
inline constexpr char kDamagedMark = '!';

/// Start of a comment in a candump log that gives the time of its zero.
inline constexpr std::string_view kCandumpZero = "# zero ";

using Mistake = tl::unexpected<std::string>;

/// An error as `file:line:column: text`. Line and column count from 1.
Mistake mistake_at(std::string_view file, unsigned line, unsigned column, std::string_view text);

/// `text` in quotation marks; a long one is cut.
std::string quoted(std::string_view text);

/// `text` without the characters of `blanks` at its start and end.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t\r");

/// Reads decimal microseconds with an optional sign and fraction; keeps nanoseconds.
std::optional<Duration> parse_microseconds(std::string_view text);

/// One line: the text before its comment, and the comment.
struct Line {
    unsigned number = 0;
    std::string_view text;
    std::string_view comment;
};

/// Iterates over the lines of a text. Skips a byte order mark at its start.
class Lines {
  public:
    explicit Lines(std::string_view content);
    bool next(Line& line);

  private:
    std::string_view rest_;
    unsigned number_ = 0;
};

struct Token {
    std::string_view text;
    unsigned column = 1;
};

/// Iterates over the words of a line.
class Tokens {
  public:
    explicit Tokens(std::string_view line) : line_(line) {}
    bool next(Token& token);

  private:
    std::string_view line_;
    std::size_t at_ = 0;
};

/// Bytes that do not occur in text: their number, and the place of the first one.
struct Oddities {
    std::size_t count = 0;
    unsigned line = 0;
    unsigned column = 0;
};

/// Counts control characters everywhere, and bytes above ASCII outside comments, which may be in
/// any language.
Oddities find_oddities(std::string_view content);

}  // namespace tribus::recording_text
