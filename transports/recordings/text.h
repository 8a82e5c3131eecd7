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

/// Upper limit of the bytes of a line. The rest of a longer one is left out.
inline constexpr std::size_t kLongestLine = std::size_t{1024} * 1024;

/// One line: the text before its comment, and the comment.
struct Line {
    unsigned number = 0;
    std::string_view text;
    std::string_view comment;
    bool has_end = true;    ///< false: the content ends within this line
    bool too_long = false;  ///< longer than kLongestLine
};

/// The mistake of a line that is too long.
Mistake too_long_line(std::string_view file, const Line& line);

/// Why the rest of a content was not read: the mistake in its last line, which has no end.
std::string cut_line_text(std::string_view mistake);

/// Why the rest of a content was not read: NUL bytes from this place on.
std::string nul_text(std::string_view file, unsigned line, unsigned column);

/// Iterates over the lines of a text. Skips a byte order mark at its start. Ends before the line
/// with the first NUL byte: a file whose end was not written to the disk when power was lost holds
/// NUL bytes there. A line is valid until the next one is asked for.
class Lines {
  public:
    explicit Lines(std::string_view content);
    /// `pieces` must outlive it. Begins where they stand, which must be at the start.
    explicit Lines(Pieces& pieces);
    bool next(Line& line);
    /// Whether NUL bytes ended it.
    bool ended_by_nul() const { return nul_column_ > 0; }
    /// `file:line:column: text` about them.
    std::string nul_text(std::string_view file) const {
        return recording_text::nul_text(file, number_ + 1, nul_column_);
    }

  private:
    std::string_view whole_line();
    void keep(std::string_view part);

    Pieces* pieces_ = nullptr;
    std::string_view rest_;
    /// The beginning of a line that began in an earlier piece.
    std::string begun_;
    bool ended_ = false;
    bool too_long_ = false;
    unsigned number_ = 0;
    unsigned nul_column_ = 0;
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
/// outside comments, which may be in any language. NUL bytes behind the lines of a text are left
/// out (see Lines).
class Oddities {
  public:
    /// Takes the next piece of a content. A byte order mark must not be in it.
    void take(std::string_view piece);

    std::size_t count() const { return count_ + odd_nuls(); }
    /// Bytes taken.
    std::size_t size() const { return size_ - (nuls_ - odd_nuls()); }
    /// Place of the first one.
    unsigned line() const { return line_; }
    unsigned column() const { return column_; }

  private:
    void found(std::size_t column);
    void take_nuls();
    std::size_t odd_nuls() const { return lines_before_ > 0 ? 0 : nuls_; }

    std::size_t count_ = 0;
    std::size_t size_ = 0;
    /// NUL bytes with nothing behind them so far.
    std::size_t nuls_ = 0;
    unsigned line_ = 0;
    unsigned column_ = 0;
    unsigned lines_before_ = 0;
    /// Bytes of the line that began in an earlier piece.
    std::size_t begun_ = 0;
    bool comment_ = false;
};

std::string_view without_byte_order_mark(std::string_view content);

}  // namespace tribus::recording_text
