#include "config/language/detours.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <utility>

#include "config/language/corrections.h"
#include "config/language/nearest.h"
#include "config/language/places.h"

namespace tribus {

bool is_word(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
}

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kBlank = " \t\r";
    const std::size_t begin = text.find_first_not_of(kBlank);
    if (begin == std::string_view::npos) {
        return {};
    }
    return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

bool is_header(std::string_view line) {
    return trimmed(line).starts_with('[');
}

namespace {

/// Whether the line starts a statement: `key = ...` or a header.
bool starts_statement(std::string_view line) {
    const std::string_view text = trimmed(line);
    const std::size_t equals = text.find('=');
    return is_header(line) || (equals != std::string_view::npos &&
                               std::all_of(text.begin(), text.begin() + std::ptrdiff_t(equals),
                                           [](char c) { return is_word(c) || c == ' '; }));
}

bool means_truth(std::string_view value) {
    constexpr std::array<std::string_view, 6> kWords{"true", "false", "yes", "no", "on", "off"};
    return nearest(value, kWords).has_value();
}

std::optional<Detour> quote_value(const Lines& lines, std::size_t line) {
    const std::string_view text = lines[line];
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos || is_header(text)) {
        return std::nullopt;
    }
    const std::string_view key = trimmed(text.substr(0, equals));
    const std::string_view rest = text.substr(equals + 1);
    const std::string_view value = trimmed(rest.substr(0, rest.find('#')));
    const bool plain = std::all_of(value.begin(), value.end(), [](char c) {
        return is_word(c) || c == '/' || c == '.' || c == ':' || c == ',' || c == '+' || c == ' ';
    });
    if (value.empty() || !plain) {
        return std::nullopt;
    }
    std::string repaired = fmt::format("{} = \"{}\"", key, value);
    std::string message = fmt::format("{} is not a valid value; ", value);
    message += means_truth(value) ? "allowed: true or false, or text in quotes"
                                  : "put text and durations in quotes: " + repaired;
    return Detour{line, {std::move(repaired)}, false, std::move(message)};
}

std::vector<Detour> close_line(const Lines& lines, std::size_t line) {
    std::vector<Detour> detours;
    for (const std::string_view closer : {"\"", "'", "]", "}", "]]", "\"]", "\" }"}) {
        std::string repaired = std::string(trimmed(lines[line])) + std::string(closer);
        detours.push_back(
            {line,
             {std::move(repaired)},
             false,
             fmt::format("this line ends too early; a closing {} is missing", closer)});
    }
    return detours;
}

Detour leave_out(const Lines& lines, std::size_t first, std::size_t last) {
    Detour detour{first, Lines(last - first + 1), true, {}};
    for (std::size_t line = first; line <= last; ++line) {
        if (is_header(lines[line])) {
            detour.replacement[line - first] = fmt::format("[\"{}{}\"]", kLostTable, line + 1);
        }
    }
    return detour;
}

/// The statement before a line that may still be open: its first line and its last non-empty line.
struct OpenStatement {
    std::size_t first = 0;
    std::size_t last = 0;
};

std::optional<OpenStatement> statement_before(const Lines& lines, std::size_t line) {
    std::size_t last = line;
    while (last > 0 && (last == line || trimmed(lines[last]).empty())) {
        --last;
    }
    std::size_t first = last;
    while (first > 0 && !starts_statement(lines[first])) {
        --first;
    }
    return last < line ? std::optional(OpenStatement{first, last}) : std::nullopt;
}

unsigned column_of(std::string_view line, std::size_t at) {
    TextPlace place;
    place.pass(line.substr(0, at));
    return place.where().column;
}

std::optional<Detour> correct_line(const Lines& lines, std::size_t line) {
    const auto corrections = corrections_in(lines[line]);
    if (corrections.empty()) {
        return std::nullopt;
    }
    return Detour{line,
                  {corrected(lines[line], corrections)},
                  false,
                  corrections.front().message,
                  column_of(lines[line], corrections.front().at)};
}

/// An inline table that goes on in further lines.
struct LongTable {
    std::string joined;      ///< its statement in one line
    std::size_t lines = 0;   ///< how many it has
    std::size_t begin = 0;   ///< offset of its `{` in the first line
    std::string_view key{};  ///< empty if it does not stand directly behind `key =`
};

std::optional<LongTable> long_table_in(const Lines& lines, std::size_t line) {
    constexpr std::size_t kMostLines = 64;
    LongTable table;
    std::size_t depth = 0;
    for (std::size_t at = line; at < std::min(lines.size(), line + kMostLines); ++at) {
        for (const LinePart& part : parts_of_line(lines[at])) {
            if (part.text == "{" && depth++ == 0 && at == line) {
                table.begin = part.at;
            } else if (part.text == "}" && depth > 0) {
                --depth;
            }
            const bool tight = table.joined.empty() || part.text == ",";
            table.joined += (tight ? "" : " ") + std::string(part.text);
        }
        if (depth == 0) {
            table.lines = at - line + 1;
            break;
        }
    }
    const auto first = parts_of_line(lines[line]);
    if (first.size() > 2 && first[1].text == "=" && first[2].at == table.begin) {
        table.key = first[0].text;
    }
    table.joined = corrected(table.joined, corrections_in(table.joined));
    return table.lines > 1 ? std::optional(std::move(table)) : std::nullopt;
}

/// The header of the table that the line belongs to, without its brackets. Empty if there is none,
/// if it is a list, or if it could not be read.
std::string_view table_of_line(const Lines& lines, std::size_t line) {
    while (line > 0 && !is_header(lines[line])) {
        --line;
    }
    const std::string_view header = trimmed(lines[line]);
    const bool table = header.starts_with('[') && !header.starts_with("[[") &&
                       header.find(kLostTable) == std::string_view::npos;
    return table ? header.substr(1, header.find(']') - 1) : std::string_view{};
}

std::optional<Detour> join_inline_table(const Lines& lines, std::size_t line) {
    constexpr std::size_t kLongestShownStatement = 100;
    const auto table = long_table_in(lines, line);
    if (!table) {
        return std::nullopt;
    }
    const std::string_view header = table_of_line(lines, line);
    std::string message = "a table between { and } must end in the line in which it begins; write ";
    message += table->joined.size() > kLongestShownStatement ? "it in one line" : table->joined;
    if (!table->key.empty() && !header.empty()) {
        message += fmt::format(", or a table [{}.{}]", header, table->key);
    }
    Detour detour{line, Lines(table->lines), false, std::move(message),
                  column_of(lines[line], table->begin)};
    detour.replacement.front() = table->joined;
    return detour;
}

}  // namespace

std::vector<Detour> detours_around(const Lines& lines, std::size_t line) {
    std::vector<Detour> detours;
    const auto add = [&detours](std::vector<Detour> more) {
        std::ranges::move(more, std::back_inserter(detours));
    };
    for (auto detour :
         {correct_line(lines, line), join_inline_table(lines, line), quote_value(lines, line)}) {
        if (detour) {
            detours.push_back(std::move(*detour));
        }
    }
    add(close_line(lines, line));
    const auto before = statement_before(lines, line);
    if (before) {
        add(close_line(lines, before->last));
        add(close_line(lines, before->first));
    }
    add({leave_out(lines, line, line)});
    if (before) {
        add({leave_out(lines, before->first, before->first),
             leave_out(lines, before->first, before->last), leave_out(lines, before->first, line)});
    }
    for (std::size_t quotes = line + 1; quotes-- > 0;) {
        if (lines[quotes].find("\"\"\"") != std::string::npos ||
            lines[quotes].find("'''") != std::string::npos) {
            add({leave_out(lines, quotes, quotes)});
            break;
        }
    }
    return detours;
}

}  // namespace tribus
