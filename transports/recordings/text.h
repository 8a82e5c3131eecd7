#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "core/time.h"
#include "transports/recordings/pieces.h"

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

/// Iterates over the lines of a text. Skips a byte order mark at its start. A line is valid until
/// the next one is asked for.
class Lines {
  public:
    explicit Lines(std::string_view content);
    /// `pieces` must outlive it. Begins where they stand, which must be at the start.
    explicit Lines(Pieces& pieces);
    bool next(Line& line);

  private:
    std::string_view whole_line();

    Pieces* pieces_ = nullptr;
    std::string_view rest_;
    /// The beginning of a line that began in an earlier piece.
    std::string begun_;
    bool ended_ = false;
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

/// Counts bytes that do not occur in text: control characters everywhere, and bytes above ASCII
/// outside comments, which may be in any language.
class Oddities {
  public:
    /// Takes the next piece of a content. A byte order mark must not be in it.
    void take(std::string_view piece);

    std::size_t count() const { return count_; }
    /// Bytes taken.
    std::size_t size() const { return size_; }
    /// Place of the first one.
    unsigned line() const { return line_; }
    unsigned column() const { return column_; }

  private:
    std::size_t count_ = 0;
    std::size_t size_ = 0;
    unsigned line_ = 0;
    unsigned column_ = 0;
    unsigned lines_before_ = 0;
    /// Bytes of the line that began in an earlier piece.
    std::size_t begun_ = 0;
    bool comment_ = false;
};

std::string_view without_byte_order_mark(std::string_view content);

}  // namespace tribus::recording_text
