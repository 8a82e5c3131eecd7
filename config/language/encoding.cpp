#include "config/language/encoding.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "config/language/places.h"
#include "core/utf8.h"

namespace tribus {
namespace {

/// An encoding with more than one byte for each letter, and the byte order mark of its files.
struct WideEncoding {
    std::string_view name;  ///< as `iconv` knows it
    std::string_view mark;
    std::size_t width;   ///< bytes of a letter
    std::size_t letter;  ///< which of them is not zero
};

/// A mark of four bytes is tried before the one of two bytes that it begins with.
constexpr std::array kWideEncodings{
    WideEncoding{"UTF-32LE", std::string_view("\xFF\xFE\0\0", 4), 4, 0},
    WideEncoding{"UTF-32BE", std::string_view("\0\0\xFE\xFF", 4), 4, 3},
    WideEncoding{"UTF-16LE", "\xFF\xFE", 2, 0},
    WideEncoding{"UTF-16BE", "\xFE\xFF", 2, 1},
};

/// Whether nearly all of the text looks like ASCII in that encoding.
bool has_letters_of(const WideEncoding& encoding, std::string_view bytes) {
    constexpr std::size_t kMostLookedAt = 256;
    constexpr std::size_t kOneInSoMany = 8;
    const std::size_t count =
        std::min(bytes.size(), kMostLookedAt) / encoding.width * encoding.width;
    std::size_t others = 0;
    for (std::size_t at = 0; at < count; ++at) {
        others += (bytes[at] != '\0') != (at % encoding.width == encoding.letter) ? 1U : 0U;
    }
    return count > 0 && others * kOneInSoMany <= count;
}

const WideEncoding* wide_encoding_of(std::string_view bytes) {
    for (const WideEncoding& encoding : kWideEncodings) {
        if (bytes.starts_with(encoding.mark) || has_letters_of(encoding, bytes)) {
            return &encoding;
        }
    }
    return nullptr;
}

/// Reports bytes that are no text, after which nothing can be read.
bool is_hopeless(std::string_view bytes, Mistakes& mistakes) {
    if (const WideEncoding* encoding = wide_encoding_of(bytes)) {
        mistakes.add({1, 1}, fmt::format("the file is in {0}; allowed: UTF-8. Save it in UTF-8, or "
                                         "convert it: iconv -f {0} -t UTF-8",
                                         encoding->name));
        return true;
    }
    const std::size_t zero = bytes.find('\0');
    if (zero != std::string_view::npos) {
        TextPlace place;
        place.pass(bytes.substr(0, zero));
        mistakes.add(place.where(), "a byte 0, which no text has; allowed: a text file in UTF-8");
    }
    return zero != std::string_view::npos;
}

std::string not_utf8(char byte, const std::string& further_lines) {
    const auto value = static_cast<unsigned char>(byte);
    const char32_t character = windows_1252_character(byte);
    if (character == kReplacementCharacter) {
        return fmt::format("byte 0x{:X} is not UTF-8{}; allowed: a text file in UTF-8", value,
                           further_lines);
    }
    std::string shown;
    append_utf8(shown, character);
    return fmt::format(
        "byte 0x{:X} is not UTF-8{}; allowed: UTF-8. In Windows-1252 and ISO 8859-1 "
        "it is {}: save the file in UTF-8, or convert it: iconv -f WINDOWS-1252 -t "
        "UTF-8",
        value, further_lines, shown);
}

/// Takes each byte that is not UTF-8 for one of Windows-1252.
std::string as_utf8(std::string_view bytes, Mistakes& mistakes) {
    std::string text;
    TextPlace place;
    RepeatedMistake wrong;
    char first = 0;
    while (!bytes.empty()) {
        const std::size_t length = std::max<std::size_t>(utf8_length(bytes), 1);
        const std::size_t before = text.size();
        if (utf8_length(bytes) == 0) {
            first = wrong.empty() ? bytes.front() : first;
            wrong.add(place.where());
            append_utf8(text, windows_1252_character(bytes.front()));
        } else {
            text += bytes.substr(0, length);
        }
        place.pass(std::string_view(text).substr(before));
        bytes.remove_prefix(length);
    }
    if (!wrong.empty()) {
        mistakes.add(wrong.first(), not_utf8(first, wrong.further_lines()));
    }
    return text;
}

/// Ends each line with LF or CR LF. Lines are counted as editors do: CR alone ends one too.
std::string with_line_ends(std::string_view bytes, Mistakes& mistakes) {
    std::string text;
    TextPlace place;
    RepeatedMistake alone;
    RepeatedMistake doubled;
    while (!bytes.empty()) {
        const std::size_t returns = std::min(bytes.find_first_not_of('\r'), bytes.size());
        const bool line_feed = bytes.substr(returns).starts_with('\n');
        if (returns > 0 && !line_feed) {
            alone.add(place.where());
        } else if (returns > 1) {
            doubled.add(place.where());
        }
        const std::size_t before = text.size();
        if (returns > 0) {
            text += line_feed ? std::string("\r") : std::string(returns, '\n');
        } else {
            text += bytes.front();
        }
        place.pass(std::string_view(text).substr(before));
        bytes.remove_prefix(std::max<std::size_t>(returns, 1));
    }
    constexpr std::string_view kAllowed =
        "allowed: LF, or CR LF; save the file with Unix line ends";
    if (!alone.empty()) {
        mistakes.add(alone.first(), fmt::format("the line ends with CR alone{}; {}, or convert it: "
                                                "tr '\\r' '\\n'",
                                                alone.further_lines(), kAllowed));
    }
    if (!doubled.empty()) {
        mistakes.add(doubled.first(), fmt::format("the line ends with CR CR LF{}; {}",
                                                  doubled.further_lines(), kAllowed));
    }
    return text;
}

}  // namespace

std::optional<std::string_view> decoded_text(std::string_view bytes, std::string& converted,
                                             Mistakes& mistakes) {
    if (is_hopeless(bytes, mistakes)) {
        return std::nullopt;
    }
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (bytes.starts_with(kByteOrderMark)) {
        bytes.remove_prefix(kByteOrderMark.size());
    }
    if (is_utf8(bytes) && bytes.find('\r') == std::string_view::npos) {
        return bytes;
    }
    converted = with_line_ends(as_utf8(bytes, mistakes), mistakes);
    return converted;
}

}  // namespace tribus
