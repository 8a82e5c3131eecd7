#include "config/language/read_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <optional>
#include <utility>

#include "config/language/nearest.h"
#include "config/language/parse_toml.h"

namespace tribus {
namespace {

using Lines = std::vector<std::string>;
using Parsed = tl::expected<Table, SyntaxError>;

/// Prefix of the table that replaces a header which could not be read.
constexpr std::string_view kLostTable = "lost table of line ";

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

/// Whether the line starts a statement: `key = ...` or a header.
bool starts_statement(std::string_view line) {
    const std::string_view text = trimmed(line);
    const std::size_t equals = text.find('=');
    return is_header(line) || (!text.empty() && equals != std::string_view::npos &&
                               std::all_of(text.begin(), text.begin() + std::ptrdiff_t(equals),
                                           [](char c) { return is_word(c) || c == ' '; }));
}

Lines split(std::string_view text) {
    Lines lines;
    while (true) {
        const std::size_t end = text.find('\n');
        lines.emplace_back(text.substr(0, end));
        if (end == std::string_view::npos) {
            return lines;
        }
        text.remove_prefix(end + 1);
    }
}

std::string join(const Lines& lines) {
    std::string text;
    for (const std::string& line : lines) {
        text += line;
        text += '\n';
    }
    text.pop_back();
    return text;
}

/// One way to continue after a mistake of syntax: other text for the lines from `first` (counted
/// from 0).
struct Detour {
    std::size_t first = 0;
    Lines replacement;
    bool loses_text = false;
    std::string text;  ///< what is wrong, if the detour shows it
};

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

/// Detours, those with the smallest change first.
std::vector<Detour> detours_around(const Lines& lines, std::size_t line) {
    std::vector<Detour> detours;
    const auto add = [&detours](std::vector<Detour> more) {
        std::ranges::move(more, std::back_inserter(detours));
    };
    if (auto quoting = quote_value(lines, line)) {
        detours.push_back(std::move(*quoting));
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

/// Line of the next mistake: how far the parser gets.
std::size_t reach(const Parsed& parsed) {
    return parsed ? std::numeric_limits<std::size_t>::max() : parsed.error().where.line;
}

bool given_twice(const SyntaxError& error) {
    return error.text.find("redefine") != std::string::npos;
}

std::string without_detour(const SyntaxError& error) {
    if (given_twice(error)) {
        return "this key or table was already given further up; give each once";
    }
    return error.whole ? error.text : fmt::format("not valid TOML: {}", error.text);
}

class Recovery {
  public:
    Recovery(std::string_view text, Mistakes& mistakes)
        : lines_(split(text)), parsed_(parse_toml(text)), mistakes_(mistakes) {}

    Document read() {
        Document document;
        for (std::size_t count = 0; !parsed_; ++count) {
            const bool spent = count == kMostSyntaxMistakes || reparsed_ > kMostReparsedBytes;
            if (spent || !go_on(document.lost)) {
                document.readable = false;
                return document;
            }
        }
        document.root = std::move(*parsed_);
        std::erase_if(document.root.entries,
                      [](const Entry& entry) { return entry.key.starts_with(kLostTable); });
        return document;
    }

  private:
    /// Records the mistake and takes the detour that gets furthest, among equals the first. Returns
    /// false if none gets further.
    bool go_on(LostText& lost) {
        const SyntaxError error = parsed_.error();
        const std::size_t line = std::clamp<std::size_t>(error.where.line, 1, lines_.size()) - 1;
        std::optional<Detour> best;
        std::size_t furthest = error.where.line;
        for (Detour& detour : detours_around(lines_, line)) {
            const std::string text = join(with(detour));
            reparsed_ += text.size();
            Parsed parsed = parse_toml(text);
            if (reach(parsed) > furthest) {
                furthest = reach(parsed);
                parsed_ = std::move(parsed);
                best = std::move(detour);
            }
        }
        if (!best) {
            report(error, {});
            return false;
        }
        record(error, *best, lost);
        lines_ = with(*best);
        return true;
    }

    Lines with(const Detour& detour) const {
        Lines lines = lines_;
        std::ranges::copy(detour.replacement, lines.begin() + std::ptrdiff_t(detour.first));
        return lines;
    }

    void report(const SyntaxError& error, const std::string& text) {
        const std::size_t line = std::clamp<std::size_t>(error.where.line, 1, lines_.size()) - 1;
        // If a whole statement is wrong, the place is its start.
        const Location where = given_twice(error) ? begin_of(line) : error.where;
        mistakes_.add(where, text.empty() ? without_detour(error) : text);
    }

    Location begin_of(std::size_t line) const {
        const std::size_t begin = lines_[line].find_first_not_of(" \t");
        return {static_cast<unsigned>(line + 1),
                begin == std::string::npos ? 1U : static_cast<unsigned>(begin + 1)};
    }

    void record(const SyntaxError& error, const Detour& detour, LostText& lost) {
        const bool earlier = detour.first + detour.replacement.size() < error.where.line;
        if (earlier && detour.loses_text) {
            mistakes_.add(
                begin_of(detour.first),
                "the statement that begins here does not end; a closing quote, ] or } is missing");
        } else if (earlier) {
            const std::size_t length = trimmed(lines_[detour.first]).size();
            Location where = begin_of(detour.first);
            where.column += static_cast<unsigned>(length);
            mistakes_.add(where, detour.text);
        } else {
            report(error, detour.text);
        }
        if (!detour.loses_text) {
            return;
        }
        for (std::size_t i = 0; i < detour.replacement.size(); ++i) {
            lost.add_line(lines_[detour.first + i], header_above(detour.first + i));
        }
    }

    unsigned header_above(std::size_t line) const {
        while (line > 0 && !is_header(lines_[line])) {
            --line;
        }
        return static_cast<unsigned>(line + 1);
    }

    Lines lines_;
    Parsed parsed_;
    std::size_t reparsed_ = 0;
    Mistakes& mistakes_;
};

}  // namespace

void LostText::add_line(std::string_view line, unsigned header_line) {
    header_lines_.insert(header_line);
    while (!line.empty()) {
        const auto begin = std::find_if(line.begin(), line.end(), is_word);
        const auto end = std::find_if_not(begin, line.end(), is_word);
        words_.emplace(begin, end);
        line.remove_prefix(static_cast<std::size_t>(end - line.begin()));
    }
}

bool LostText::mentions(std::string_view word) const {
    return words_.find(word) != words_.end();
}

Document read_document(std::string_view text, Mistakes& mistakes) {
    if (text.size() > kMostConfigurationBytes) {
        mistakes.add({1, 1}, fmt::format("the file is too long; allowed: at most {} bytes",
                                         kMostConfigurationBytes));
        Document document;
        document.readable = false;
        return document;
    }
    return Recovery(text, mistakes).read();
}

}  // namespace tribus
