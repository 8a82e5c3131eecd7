#include "transports/codecs/dbc/lexer.h"

#include "core/utf8.h"

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
        append_utf8(converted, windows_1252_character(byte));
    }
    return converted;
}

}  // namespace tribus
