#include "config/language/read_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "config/language/detours.h"
#include "config/language/parse_toml.h"

namespace tribus {
namespace {

using Parsed = tl::expected<Table, SyntaxError>;

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
        : text_(text), parsed_(parse_toml(text)), mistakes_(mistakes) {}

    Document read() {
        Document document;
        // A text without mistakes needs no lines of its own.
        lines_ = parsed_ ? Lines{} : split(text_);
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
            report(error, std::string());
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

    void report(const SyntaxError& error, const Detour& detour) {
        if (detour.column) {
            const auto number = static_cast<unsigned>(detour.first + 1);
            mistakes_.add({number, *detour.column}, detour.text);
        } else {
            report(error, detour.text);
        }
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
            report(error, detour);
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

    std::string_view text_;
    Lines lines_;
    Parsed parsed_;
    std::size_t reparsed_ = 0;
    Mistakes& mistakes_;
};

}  // namespace

void LostText::add_line(std::string_view line, unsigned header_line) {
    // Names with letters beyond ASCII are not allowed, but are tried.
    const auto in_name = [](char c) { return is_word(c) || static_cast<unsigned char>(c) >= 0x80; };
    header_lines_.insert(header_line);
    while (!line.empty()) {
        const auto begin = std::find_if(line.begin(), line.end(), in_name);
        const auto end = std::find_if_not(begin, line.end(), in_name);
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
