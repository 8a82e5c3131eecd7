#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "core/time.h"

/// What the readers of recordings share: lines, words, numbers, mistakes. Pure.
namespace tribus::recording_text {

/// Behind a byte that came with a parity or framing error.
inline constexpr char kDamagedMark = '!';

/// A comment that says what a log of candump calls its zero; the time follows.
inline constexpr std::string_view kCandumpZero = "# zero ";

using Mistake = tl::unexpected<std::string>;

/// `file:line:column: text`, both counted from 1.
Mistake mistake_at(std::string_view file, unsigned line, unsigned column, std::string_view text);

/// In quotation marks, a long one cut.
std::string quoted(std::string_view text);

/// Without those of `blanks` that it starts or ends with.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t\r");

/// Decimal microseconds with an optional sign and fraction, of which nanoseconds are kept.
std::optional<Duration> parse_microseconds(std::string_view text);

/// One line: what stands before its comment, and the comment.
struct Line {
    unsigned number = 0;
    std::string_view text;
    std::string_view comment;
};

/// Walks over the lines of a text; a byte order mark in front is none of it.
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

/// Walks over the words of a line.
class Tokens {
  public:
    explicit Tokens(std::string_view line) : line_(line) {}
    bool next(Token& token);

  private:
    std::string_view line_;
    std::size_t at_ = 0;
};

/// Bytes that no text has: how many, and where the first one stands.
struct Oddities {
    std::size_t count = 0;
    unsigned line = 0;
    unsigned column = 0;
};

/// Control characters anywhere; bytes above ASCII outside comments, where they may be a word in
/// someone's language.
Oddities find_oddities(std::string_view content);

}  // namespace tribus::recording_text
