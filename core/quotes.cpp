#include "core/quotes.h"

#include <algorithm>

#include "core/utf8.h"

namespace tribus {

namespace {

/// Length of the whole UTF-8 characters within the first `most` bytes.
std::size_t whole_characters(std::string_view text, std::size_t most) {
    while (most > 0 && (static_cast<unsigned char>(text[most]) & 0xC0U) == 0x80U) {
        --most;
    }
    return most;
}

}  // namespace

std::string in_quotes(std::string_view text, std::size_t most) {
    const bool cut = text.size() > most;
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string result = "\"";
    const auto as_hex = [&](unsigned char code) {
        result.append({kDigits[code / 16], kDigits[code % 16]});
    };
    std::string_view rest = text.substr(0, cut ? whole_characters(text, most) : text.size());
    for (std::size_t length = 0; !rest.empty();
         rest.remove_prefix(std::max<std::size_t>(length, 1))) {
        const char c = rest.front();
        const auto code = static_cast<unsigned char>(c);
        length = utf8_length(rest);
        if (c == '"' || c == '\\') {
            result += '\\';
            result += c;
        } else if (code < 0x20 || code == 0x7F) {
            result += "\\u00";
            as_hex(code);
        } else if (length == 0) {
            result += "\\x";
            as_hex(code);
        } else {
            result += rest.substr(0, length);
        }
    }
    return result + (cut ? "\"..." : "\"");
}

std::string in_quotes_all(std::span<const std::string_view> names) {
    std::string result;
    for (const std::string_view name : names) {
        result += result.empty() ? "" : ", ";
        result += in_quotes(name);
    }
    return result;
}

}  // namespace tribus
