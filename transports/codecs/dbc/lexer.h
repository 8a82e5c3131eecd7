#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace tribus {

/// A place in a text, counted from 1; columns in bytes.
struct DbcPlace {
    unsigned line = 1;
    unsigned column = 1;
};

enum class DbcTokenKind : std::uint8_t {
    end,
    word,          ///< letters, digits, '_' and whatever is not ASCII
    number,        ///< starts like one, without sign; may still be malformed ("12ab")
    string,        ///< text is what stands between the quotes, as in the file
    unterminated,  ///< a string without end; the place is that of its opening quote
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

/// Cuts a DBC text into tokens that point into it. Skips blanks, a byte order mark and `//`
/// comments. Never fails: what is malformed comes out as a token that says so. Thread-bound.
class DbcLexer {
  public:
    explicit DbcLexer(std::string_view text);

    /// The next token; `end` for ever after the last.
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

/// The text of a string token: without escapes of quote and backslash, and in UTF-8.
std::string dbc_string(std::string_view between_quotes);

/// The same text if it is UTF-8, else what it is in cp1252, which the usual editors write.
std::string utf8_from_dbc(std::string_view text);

}  // namespace tribus
