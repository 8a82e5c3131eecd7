#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace tribus {

/// A position in a text. Lines and columns count from 1, columns in bytes.
struct DbcPlace {
    unsigned line = 1;
    unsigned column = 1;
};

enum class DbcTokenKind : std::uint8_t {
    end,
    word,          ///< letters, digits, '_' and all bytes that are not ASCII
    number,        ///< begins like a number, without a sign; may be malformed ("12ab")
    string,        ///< the text between the quotes, as in the file
    unterminated,  ///< a string without end, at the place of its opening quote
    mark,          ///< any other single byte
};

struct DbcToken {
    DbcTokenKind kind = DbcTokenKind::end;
    std::string_view text;
    DbcPlace place;
    bool first_on_line = false;

    bool is_mark(char mark) const { return kind == DbcTokenKind::mark && text.front() == mark; }
    bool is_word(std::string_view word) const { return kind == DbcTokenKind::word && text == word; }
};

/// Cuts a DBC text into tokens, which point into the text. Skips blanks, a byte order mark and `//`
/// comments. Never fails: malformed text gives a token of a kind that shows it. Thread-bound.
class DbcLexer {
  public:
    explicit DbcLexer(std::string_view text);

    /// The next token. After the last one, always `end`.
    DbcToken next();

  private:
    void skip_blanks();
    void advance(std::size_t count);
    std::size_t word_length() const;
    std::size_t number_length() const;
    /// Without the quotes; npos if the string has no end.
    std::size_t string_length() const;

    std::string_view rest_;
    DbcPlace place_;
    unsigned line_of_latest_ = 0;
};

/// The text of a string token as UTF-8, with the escapes of quote and backslash resolved.
std::string dbc_string(std::string_view between_quotes);

/// The text itself if it is UTF-8, else converted from cp1252, which the usual editors write.
std::string utf8_from_dbc(std::string_view text);

}  // namespace tribus
