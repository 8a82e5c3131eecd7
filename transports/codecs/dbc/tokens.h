#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/lexer.h"

namespace tribus {

/// One token of look-ahead over a DBC text, and the first error. The `take` functions return
/// whether the token was there; if not, `mistake()` gives what was expected and found, and the
/// caller must stop. `what` names the expected thing in that message. Thread-bound.
class DbcTokens {
  public:
    explicit DbcTokens(std::string_view text) : lexer_(text), token_(lexer_.next()) {}

    const DbcToken& token() const { return token_; }
    const std::optional<DbcMistake>& mistake() const { return mistake_; }
    bool at_end() const { return token_.kind == DbcTokenKind::end; }
    /// Whether the token is a section word, first on its line: it ends a statement without end
    /// mark.
    bool at_section() const;
    void advance() { token_ = lexer_.next(); }

    /// Takes an optional mark. Returns whether it was there.
    bool skip_mark(char mark);

    bool take_mark(char mark, std::string_view what);
    bool take_word(std::string_view& word, std::string_view what);
    bool take_string(std::string& text, std::string_view what);
    /// Without a sign, 0 to `most`.
    bool take_unsigned(std::uint64_t& value, std::uint64_t most, std::string_view what);
    bool take_unsigned(std::uint32_t& value, std::uint32_t most, std::string_view what);
    /// A whole number with or without a sign, also written as "3.0"; modulo 2^64.
    bool take_raw(std::int64_t& value, std::string_view what);
    bool take_double(double& value, std::string_view what);
    /// Like take_double, but a number outside the range of a double becomes the nearest one: tools
    /// write the limits of a double with so few digits that they are outside.
    bool take_limit(double& value, std::string_view what);
    /// Takes an optional '+' or '-'. Returns whether it was '-'.
    bool take_sign();

    /// Whether the reading can go on behind the error: the text does not end within a statement.
    bool can_go_on() const {
        return token_.kind != DbcTokenKind::end && token_.kind != DbcTokenKind::unterminated;
    }
    /// Returns the error and forgets it. There must be one.
    DbcMistake forgive() { return *std::exchange(mistake_, std::nullopt); }

    /// Keeps the first error. Returns false, so that callers can return it.
    bool fail(DbcPlace place, std::string text);
    bool fail_expected(std::string_view what);

  private:
    bool take_magnitude(double& value, bool saturates, std::string_view what);

    DbcLexer lexer_;
    DbcToken token_;
    std::optional<DbcMistake> mistake_;
};

}  // namespace tribus
