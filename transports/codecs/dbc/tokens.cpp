#include "transports/codecs/dbc/tokens.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>
#include <utility>

#include "core/quotes.h"

namespace tribus {
namespace {

constexpr std::uint64_t kMostNegative = std::uint64_t{1} << 63U;
constexpr double kTwoTo63 = 9223372036854775808.0;

constexpr std::array<std::string_view, 24> kSectionWords{
    "VERSION",     "NS_",         "BS_",     "BU_",           "VAL_TABLE_", "BO_",
    "SG_",         "BO_TX_BU_",   "EV_",     "ENVVAR_DATA_",  "SGTYPE_",    "CM_",
    "BA_DEF_",     "BA_DEF_DEF_", "BA_",     "VAL_",          "SIG_GROUP_", "SIG_VALTYPE_",
    "SG_MUL_VAL_", "BA_DEF_REL_", "BA_REL_", "SIG_TYPE_REF_", "CAT_DEF_",   "BA_DEF_DEF_REL_"};

/// Text of a token, short enough for an error message.
std::string shown(const DbcToken& token) {
    constexpr std::size_t kLongestShown = 40;
    switch (token.kind) {
        case DbcTokenKind::end:
            return "the end of the file";
        case DbcTokenKind::string:
            return "the text " + in_quotes(utf8_from_dbc(token.text), kLongestShown);
        default:
            return "'" + utf8_from_dbc(token.text.substr(0, kLongestShown)) + "'";
    }
}

template <class Value>
std::errc convert(std::string_view text, Value& value) {
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    return error == std::errc{} && stop != end ? std::errc::invalid_argument : error;
}

/// For a number outside the range of a double: 0 if its exponent is negative.
double nearest_double(std::string_view text) {
    const std::size_t exponent = text.find_first_of("eE");
    const bool tiny = exponent != std::string_view::npos && text[exponent + 1] == '-';
    return tiny ? 0 : std::numeric_limits<double>::max();
}

}  // namespace

bool DbcTokens::fail(DbcPlace place, std::string text) {
    if (!mistake_) {
        mistake_ = DbcMistake{place.line, place.column, std::move(text)};
    }
    return false;
}

bool DbcTokens::fail_expected(std::string_view what) {
    if (token_.kind == DbcTokenKind::unterminated) {
        return fail(token_.place, "text without its closing quote");
    }
    return fail(token_.place, "expected " + std::string(what) + ", found " + shown(token_));
}

bool DbcTokens::at_section() const {
    return token_.kind == DbcTokenKind::word && token_.first_on_line &&
           std::find(kSectionWords.begin(), kSectionWords.end(), token_.text) !=
               kSectionWords.end();
}

bool DbcTokens::skip_mark(char mark) {
    const bool found = token_.is_mark(mark);
    if (found) {
        advance();
    }
    return found;
}

bool DbcTokens::take_mark(char mark, std::string_view what) {
    return skip_mark(mark) || fail_expected("'" + std::string(1, mark) + "' " + std::string(what));
}

bool DbcTokens::take_word(std::string_view& word, std::string_view what) {
    if (token_.kind != DbcTokenKind::word) {
        return fail_expected(what);
    }
    word = token_.text;
    advance();
    return true;
}

bool DbcTokens::take_string(std::string& text, std::string_view what) {
    if (token_.kind != DbcTokenKind::string) {
        return fail_expected(what);
    }
    text = dbc_string(token_.text);
    advance();
    return true;
}

bool DbcTokens::take_unsigned(std::uint64_t& value, std::uint64_t most, std::string_view what) {
    const bool whole = token_.kind == DbcTokenKind::number &&
                       convert(token_.text, value) == std::errc{} && value <= most;
    if (!whole) {
        return fail_expected(std::string(what) + ", a whole number from 0 to " +
                             std::to_string(most));
    }
    advance();
    return true;
}

bool DbcTokens::take_unsigned(std::uint32_t& value, std::uint32_t most, std::string_view what) {
    std::uint64_t wide = 0;
    if (!take_unsigned(wide, std::uint64_t{most}, what)) {
        return false;
    }
    value = static_cast<std::uint32_t>(wide);
    return true;
}

bool DbcTokens::take_sign() {
    return skip_mark('-') || (skip_mark('+') && false);
}

bool DbcTokens::take_raw(std::int64_t& value, std::string_view what) {
    const bool negative = take_sign();
    std::uint64_t magnitude = 0;
    double fraction = 0;
    if (token_.kind != DbcTokenKind::number) {
        return fail_expected(what);
    }
    if (convert(token_.text, magnitude) != std::errc{}) {
        const bool whole = convert(token_.text, fraction) == std::errc{} &&
                           fraction == std::trunc(fraction) && fraction < kTwoTo63;
        if (!whole) {
            return fail_expected(std::string(what) + ", a whole number of 64 bits");
        }
        magnitude = static_cast<std::uint64_t>(fraction);
    }
    if (negative && magnitude > kMostNegative) {
        return fail_expected(std::string(what) + ", a whole number of 64 bits");
    }
    value = static_cast<std::int64_t>(negative ? 0 - magnitude : magnitude);
    advance();
    return true;
}

bool DbcTokens::take_magnitude(double& value, bool saturates, std::string_view what) {
    std::errc error = std::errc::invalid_argument;
    if (token_.kind == DbcTokenKind::number) {
        error = convert(token_.text, value);
    }
    if (error == std::errc::result_out_of_range && saturates) {
        value = nearest_double(token_.text);
    } else if (error != std::errc{}) {
        return fail_expected(std::string(what) + ", a number such as 0.5 or 1E-3");
    }
    advance();
    return true;
}

bool DbcTokens::take_double(double& value, std::string_view what) {
    const bool negative = take_sign();
    const bool taken = take_magnitude(value, false, what);
    value = negative ? -value : value;
    return taken;
}

bool DbcTokens::take_limit(double& value, std::string_view what) {
    const bool negative = take_sign();
    const bool taken = take_magnitude(value, true, what);
    value = negative ? -value : value;
    return taken;
}

}  // namespace tribus
