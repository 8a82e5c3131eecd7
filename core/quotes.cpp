#include "core/quotes.h"

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
    for (const char c : text.substr(0, cut ? whole_characters(text, most) : text.size())) {
        const auto code = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            result += '\\';
            result += c;
        } else if (code < 0x20 || code == 0x7F) {
            result.append("\\u00").append({kDigits[code / 16], kDigits[code % 16]});
        } else {
            result += c;
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
