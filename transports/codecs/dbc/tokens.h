#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/lexer.h"

namespace tribus {

/// One token of look-ahead over a DBC text, and the first mistake. What takes a token returns
/// whether it was there; if not, `mistake()` says what was expected and what was found, and the
/// caller gives up. `what` names the thing for the person who reads that. Thread-bound.
class DbcTokens {
  public:
    explicit DbcTokens(std::string_view text) : lexer_(text), token_(lexer_.next()) {}

    const DbcToken& token() const { return token_; }
    const std::optional<DbcMistake>& mistake() const { return mistake_; }
    bool at_end() const { return token_.kind == DbcTokenKind::end; }
    /// At a word that begins a section, first on its line: where a statement without end mark ends.
    bool at_section() const;
    void advance() { token_ = lexer_.next(); }

    /// Takes a mark that need not be there.
    bool skip_mark(char mark);

    bool take_mark(char mark, std::string_view what);
    bool take_word(std::string_view& word, std::string_view what);
    bool take_string(std::string& text, std::string_view what);
    /// Without sign, `most` at most.
    bool take_unsigned(std::uint64_t& value, std::uint64_t most, std::string_view what);
    bool take_unsigned(std::uint32_t& value, std::uint32_t most, std::string_view what);
    /// A whole number with or without sign, also written as "3.0"; modulo 2^64.
    bool take_raw(std::int64_t& value, std::string_view what);
    bool take_double(double& value, std::string_view what);
    /// The same; what is beyond a double becomes the nearest one. Tools write the limits of a
    /// double with so few digits that they lie outside.
    bool take_limit(double& value, std::string_view what);
    /// '+' or '-', which need not be there.
    bool take_sign();

    /// Remembers the mistake; false, so that callers can return it.
    bool fail(DbcPlace place, std::string text);
    bool fail_expected(std::string_view what);

  private:
    bool take_magnitude(double& value, bool saturates, std::string_view what);

    DbcLexer lexer_;
    DbcToken token_;
    std::optional<DbcMistake> mistake_;
};

}  // namespace tribus
