#include "transports/codecs/dbc/lexer.h"

#include <array>
#include <cstdint>

namespace tribus {
namespace {

bool is_digit(char byte) {
    return byte >= '0' && byte <= '9';
}

bool is_word_byte(char byte) {
    const auto value = static_cast<unsigned char>(byte);
    return is_digit(byte) || byte == '_' || (byte >= 'A' && byte <= 'Z') ||
           (byte >= 'a' && byte <= 'z') || value >= 0x80;
}

/// Old editors end a file with 0x1A.
bool is_blank(char byte) {
    return byte == ' ' || (byte >= '\t' && byte <= '\r') || byte == '\x1A';
}

/// Length in bytes of the UTF-8 character at the start of `text`; 0 if it is not valid.
std::size_t utf8_length(std::string_view text) {
    const auto byte = [&](std::size_t at) -> unsigned {
        return at < text.size() ? static_cast<unsigned char>(text[at]) : 0U;
    };
    const unsigned first = byte(0);
    const std::size_t length = first < 0x80                     ? 1
                               : first >= 0xC2 && first <= 0xDF ? 2
                               : first >= 0xE0 && first <= 0xEF ? 3
                               : first >= 0xF0 && first <= 0xF4 ? 4
                                                                : 0;
    for (std::size_t at = 1; at < length; ++at) {
        if ((byte(at) & 0xC0U) != 0x80) {
            return 0;
        }
    }
    // An overlong form, half of a surrogate pair, or beyond the last character.
    const bool forbidden = (first == 0xE0 && byte(1) < 0xA0) || (first == 0xED && byte(1) > 0x9F) ||
                           (first == 0xF0 && byte(1) < 0x90) || (first == 0xF4 && byte(1) > 0x8F);
    return forbidden ? 0 : length;
}

bool is_utf8(std::string_view text) {
    while (!text.empty()) {
        const std::size_t length = utf8_length(text);
        if (length == 0) {
            return false;
        }
        text.remove_prefix(length);
    }
    return true;
}

/// 0x80 to 0x9F of cp1252 in Unicode. Its five gaps become the replacement character.
constexpr std::array<std::uint16_t, 32> kCp1252{
    0x20AC, 0xFFFD, 0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021, 0x02C6, 0x2030, 0x0160,
    0x2039, 0x0152, 0xFFFD, 0x017D, 0xFFFD, 0xFFFD, 0x2018, 0x2019, 0x201C, 0x201D, 0x2022,
    0x2013, 0x2014, 0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0xFFFD, 0x017E, 0x0178};

void append_utf8(std::string& text, unsigned character) {
    const auto put = [&](unsigned byte) { text.push_back(static_cast<char>(byte)); };
    if (character < 0x80) {
        put(character);
    } else if (character < 0x800) {
        put(0xC0U | (character >> 6U));
        put(0x80U | (character & 0x3FU));
    } else {
        put(0xE0U | (character >> 12U));
        put(0x80U | ((character >> 6U) & 0x3FU));
        put(0x80U | (character & 0x3FU));
    }
}

}  // namespace

DbcLexer::DbcLexer(std::string_view text) : rest_(text) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (rest_.starts_with(kByteOrderMark)) {
        rest_.remove_prefix(kByteOrderMark.size());
    }
}

DbcToken DbcLexer::next() {
    skip_blanks();
    DbcToken token;
    token.place = place_;
    token.first_on_line = place_.line != line_of_latest_;
    if (rest_.empty()) {
        return token;
    }
    const bool fraction = rest_.size() > 1 && rest_[0] == '.' && is_digit(rest_[1]);
    std::size_t quotes = 0;
    std::size_t length = 1;
    if (is_digit(rest_[0]) || fraction) {
        token.kind = DbcTokenKind::number;
        length = number_length();
    } else if (is_word_byte(rest_[0])) {
        token.kind = DbcTokenKind::word;
        length = word_length();
    } else if (rest_[0] != '"') {
        token.kind = DbcTokenKind::mark;
    } else if (length = string_length(); length == std::string_view::npos) {
        token.kind = DbcTokenKind::unterminated;
        length = rest_.size() - 1;
        quotes = 1;
    } else {
        token.kind = DbcTokenKind::string;
        quotes = 2;
    }
    token.text = rest_.substr(quotes == 0 ? 0 : 1, length);
    advance(length + quotes);
    line_of_latest_ = place_.line;
    return token;
}

void DbcLexer::skip_blanks() {
    while (!rest_.empty()) {
        if (is_blank(rest_[0])) {
            advance(1);
        } else if (rest_.starts_with("//")) {
            const std::size_t end = rest_.find('\n');
            advance(end == std::string_view::npos ? rest_.size() : end);
        } else {
            return;
        }
    }
}

void DbcLexer::advance(std::size_t count) {
    for (const char byte : rest_.substr(0, count)) {
        if (byte == '\n') {
            ++place_.line;
            place_.column = 1;
        } else {
            ++place_.column;
        }
    }
    rest_.remove_prefix(count);
}

std::size_t DbcLexer::word_length() const {
    std::size_t length = 0;
    while (length < rest_.size() && is_word_byte(rest_[length])) {
        ++length;
    }
    return length;
}

// A sign belongs to a number only after the 'e' of an exponent: "8@1+" and "16-20" are several
// tokens.
std::size_t DbcLexer::number_length() const {
    std::size_t length = 0;
    bool decimal = true;
    while (length < rest_.size()) {
        const char byte = rest_[length];
        const bool exponent = decimal && (byte == 'e' || byte == 'E');
        if (!is_word_byte(byte) && byte != '.') {
            return length;
        }
        decimal = decimal && (is_digit(byte) || byte == '.');
        ++length;
        if (exponent && length < rest_.size() && (rest_[length] == '+' || rest_[length] == '-')) {
            ++length;
        }
    }
    return length;
}

std::size_t DbcLexer::string_length() const {
    for (std::size_t at = 1; at < rest_.size(); ++at) {
        const bool escape = rest_[at] == '\\' && at + 1 < rest_.size() &&
                            (rest_[at + 1] == '"' || rest_[at + 1] == '\\');
        if (escape) {
            ++at;
        } else if (rest_[at] == '"') {
            return at - 1;
        }
    }
    return std::string_view::npos;
}

std::string dbc_string(std::string_view between_quotes) {
    std::string text;
    for (std::size_t at = 0; at < between_quotes.size(); ++at) {
        const bool escape = between_quotes[at] == '\\' && at + 1 < between_quotes.size() &&
                            (between_quotes[at + 1] == '"' || between_quotes[at + 1] == '\\');
        at += escape ? 1U : 0U;
        text.push_back(between_quotes[at]);
    }
    return utf8_from_dbc(text);
}

std::string utf8_from_dbc(std::string_view text) {
    if (is_utf8(text)) {
        return std::string(text);
    }
    std::string converted;
    for (const char byte : text) {
        const unsigned value = static_cast<unsigned char>(byte);
        append_utf8(converted, value >= 0x80 && value < 0xA0 ? kCp1252[value - 0x80] : value);
    }
    return converted;
}

}  // namespace tribus
