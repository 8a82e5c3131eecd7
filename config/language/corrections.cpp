#include "config/language/corrections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>

#include "config/language/detours.h"
#include "config/language/numbers.h"

namespace tribus {
namespace {

/// Long enough for a path, short enough for a message that shows it three times.
constexpr std::size_t kLongestShownText = 60;

/// A character beyond ASCII is not torn apart.
bool is_number_or_word(char c) {
    return is_word(c) || c == '.' || c == '+' || c == ':' || static_cast<unsigned char>(c) >= 0x80;
}

/// Length of the text with its quotes at the start of `rest`; to the end if it does not end.
std::size_t quoted_length(std::string_view rest) {
    const std::string_view ends = rest.front() == '"' ? "\"\\" : "'";
    std::size_t at = rest.find_first_of(ends, 1);
    while (at != std::string_view::npos && rest[at] == '\\') {
        at = rest.find_first_of(ends, at + 2);
    }
    return at == std::string_view::npos ? rest.size() : at + 1;
}

bool has_hex_digits(std::string_view text, std::size_t count) {
    return text.size() >= count && std::ranges::all_of(text.substr(0, count), [](char c) {
               return std::isxdigit(static_cast<unsigned char>(c)) != 0;
           });
}

/// Whether a backslash begins something that is no escape of TOML.
bool has_wrong_escape(std::string_view content) {
    for (std::size_t at = 0; at < content.size(); ++at) {
        if (content[at] != '\\') {
            continue;
        }
        const std::string_view rest = content.substr(at + 1);
        const bool plain =
            !rest.empty() && std::string_view("btnfr\"\\").find(rest[0]) != std::string_view::npos;
        const bool unicode = (rest.starts_with('u') && has_hex_digits(rest.substr(1), 4)) ||
                             (rest.starts_with('U') && has_hex_digits(rest.substr(1), 8));
        if (!plain && !unicode) {
            return true;
        }
        ++at;
    }
    return false;
}

std::string with_double_backslashes(std::string_view content) {
    std::string text;
    for (const char c : content) {
        text += c == '\\' ? "\\\\" : std::string(1, c);
    }
    return text;
}

std::optional<Correction> correct_text(const LinePart& part) {
    // The quote at its end may belong to a backslash that was meant as itself.
    const bool closed = part.text.starts_with('"') && part.text.ends_with('"');
    const std::string_view content =
        closed ? part.text.substr(1, part.text.size() - 2) : std::string_view{};
    if (!has_wrong_escape(content)) {
        return std::nullopt;
    }
    const std::string doubled = "\"" + with_double_backslashes(content) + "\"";
    const bool literal = content.find('\'') == std::string_view::npos;
    const std::string single = fmt::format("'{}'", content);
    const bool shown = content.size() <= kLongestShownText;
    return Correction{
        part.at, part.text.size(), doubled,
        fmt::format("{} has a backslash, which begins an escape between \"; write {}{}",
                    shown ? part.text : "this text",
                    literal ? (shown ? single : "'...'") + " or " : "",
                    shown ? doubled : "each backslash twice")};
}

bool is_part(const std::vector<LinePart>& parts, std::size_t at, std::string_view text) {
    return at < parts.size() && parts[at].text == text;
}

std::optional<Correction> correct_number(const std::vector<LinePart>& parts, std::size_t at) {
    const LinePart& part = parts[at];
    if (is_part(parts, at + 1, "=")) {
        return std::nullopt;
    }
    const auto repair = repaired_number(part.text);
    return repair ? std::optional(Correction{part.at, part.text.size(), repair->number,
                                             fmt::format("{} is not a valid value: {}; write {}",
                                                         part.text, repair->rule, repair->number)})
                  : std::nullopt;
}

bool is_whole_number(std::string_view text) {
    const std::string_view digits = text.substr(text.starts_with('-') ? 1 : 0);
    return !digits.empty() && std::ranges::all_of(digits, [](char c) {
        return std::isdigit(static_cast<unsigned char>(c)) != 0;
    });
}

/// `key = 0,3`.
std::optional<Correction> correct_decimal_comma(const std::vector<LinePart>& parts) {
    if (parts.size() != 5 || parts[1].text != "=" || parts[3].text != "," ||
        !is_whole_number(parts[2].text) || !is_whole_number(parts[4].text)) {
        return std::nullopt;
    }
    const std::string number = fmt::format("{}.{}", parts[2].text, parts[4].text);
    return Correction{parts[2].at, parts[4].at + parts[4].text.size() - parts[2].at, number,
                      fmt::format("{},{} is not a valid value: a number has a decimal point; write "
                                  "{}",
                                  parts[2].text, parts[4].text, number)};
}

}  // namespace

std::vector<LinePart> parts_of_line(std::string_view line) {
    std::vector<LinePart> parts;
    line = line.substr(0, line.find_last_not_of('\r') + 1);
    for (std::size_t at = 0; at < line.size() && line[at] != '#';) {
        const std::string_view rest = line.substr(at);
        const bool quotes = rest[0] == '"' || rest[0] == '\'';
        const auto word_end = std::ranges::find_if_not(rest, is_number_or_word);
        const auto word = static_cast<std::size_t>(word_end - rest.begin());
        const std::size_t length = quotes ? quoted_length(rest) : std::max<std::size_t>(word, 1);
        if (rest[0] != ' ' && rest[0] != '\t') {
            parts.push_back({at, rest.substr(0, length), quotes});
        }
        at += length;
    }
    return parts;
}

std::vector<Correction> corrections_in(std::string_view line) {
    std::vector<Correction> corrections;
    const auto add = [&corrections](std::optional<Correction> correction) {
        if (correction) {
            corrections.push_back(std::move(*correction));
        }
    };
    if (is_header(line)) {
        return corrections;
    }
    const auto parts = parts_of_line(line);
    if (auto comma = correct_decimal_comma(parts)) {
        return {std::move(*comma)};
    }
    for (std::size_t at = 0; at < parts.size(); ++at) {
        add(parts[at].in_quotes ? correct_text(parts[at]) : correct_number(parts, at));
        if (is_part(parts, at, ",") && is_part(parts, at + 1, "}")) {
            add(Correction{parts[at].at, 1, "",
                           "there is a comma before }, with nothing behind it; leave it out"});
        }
    }
    return corrections;
}

std::string corrected(std::string_view line, const std::vector<Correction>& corrections) {
    std::string text;
    std::size_t done = 0;
    for (const Correction& correction : corrections) {
        text += line.substr(done, correction.at - done);
        text += correction.text;
        done = correction.at + correction.length;
    }
    return text + std::string(line.substr(done));
}

}  // namespace tribus
