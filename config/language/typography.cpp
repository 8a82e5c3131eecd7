#include "config/language/typography.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "config/language/places.h"
#include "core/utf8.h"

namespace tribus {
namespace {

enum class Foreign : std::uint8_t { double_quote, single_quote, blank, dash, invisible, line_end };

struct ForeignKind {
    std::string_view name;
    std::string_view allowed;
    std::string_view replacement;
    bool visible = true;
};

/// In the order of Foreign.
constexpr std::array kForeignKinds{
    ForeignKind{"is a typographic quote", "\" or '", "\""},
    ForeignKind{"is a typographic quote", "\" or '", "'"},
    ForeignKind{"looks like a space, but is none", "a space", " ", false},
    ForeignKind{"is a dash", "the minus of the keyboard, -", "-"},
    ForeignKind{"is a character without a width", "nothing; delete it", "", false},
    ForeignKind{"does not end a line in TOML", "LF, or CR LF", "\n", false},
};

const ForeignKind& description_of(Foreign kind) {
    return kForeignKinds[static_cast<std::size_t>(kind)];
}

struct ForeignCharacters {
    char32_t first;
    char32_t last;
    Foreign kind;
};

constexpr std::array kForeignCharacters{
    ForeignCharacters{0x0B, 0x0C, Foreign::blank},         // vertical tab, form feed
    ForeignCharacters{0x60, 0x60, Foreign::single_quote},  // grave accent
    ForeignCharacters{0x85, 0x85, Foreign::line_end},      // next line
    ForeignCharacters{0xA0, 0xA0, Foreign::blank},         // no-break space
    ForeignCharacters{0xAB, 0xAB, Foreign::double_quote},  // two angles, left
    ForeignCharacters{0xAD, 0xAD, Foreign::invisible},     // soft hyphen
    ForeignCharacters{0xB4, 0xB4, Foreign::single_quote},  // acute accent
    ForeignCharacters{0xBB, 0xBB, Foreign::double_quote},  // two angles, right
    ForeignCharacters{0x2000, 0x200A, Foreign::blank},     // en quad to hair space
    ForeignCharacters{0x200B, 0x200F, Foreign::invisible},
    ForeignCharacters{0x2010, 0x2015, Foreign::dash},
    ForeignCharacters{0x2018, 0x201B, Foreign::single_quote},
    ForeignCharacters{0x201C, 0x201F, Foreign::double_quote},
    ForeignCharacters{0x2028, 0x2029, Foreign::line_end},
    ForeignCharacters{0x202A, 0x202E, Foreign::invisible},
    ForeignCharacters{0x202F, 0x202F, Foreign::blank},
    ForeignCharacters{0x2032, 0x2032, Foreign::single_quote},  // prime
    ForeignCharacters{0x2033, 0x2033, Foreign::double_quote},
    ForeignCharacters{0x2039, 0x203A, Foreign::single_quote},  // one angle
    ForeignCharacters{0x205F, 0x205F, Foreign::blank},
    ForeignCharacters{0x2060, 0x2060, Foreign::invisible},
    ForeignCharacters{0x2212, 0x2212, Foreign::dash},  // minus
    ForeignCharacters{0x3000, 0x3000, Foreign::blank},
    ForeignCharacters{0xFEFF, 0xFEFF, Foreign::invisible},  // byte order mark
    ForeignCharacters{0xFF02, 0xFF02, Foreign::double_quote},
    ForeignCharacters{0xFF07, 0xFF07, Foreign::single_quote},
};

std::optional<Foreign> foreign_kind(char32_t character) {
    const auto found = std::ranges::find_if(kForeignCharacters, [character](const auto& row) {
        return character >= row.first && character <= row.last;
    });
    return found == kForeignCharacters.end() ? std::nullopt : std::optional(found->kind);
}

class PlainCharacters {
  public:
    explicit PlainCharacters(std::string_view text) : text_(text) {}

    std::string write(Mistakes& mistakes) {
        while (!at_end()) {
            if (text_[at_] == '#') {
                copy(line_rest());
            } else if (text_[at_] == '"' || text_[at_] == '\'') {
                copy_quoted(text_[at_]);
            } else {
                copy_character();
            }
        }
        for (std::size_t kind = 0; kind < found_.size(); ++kind) {
            report(found_[kind], kForeignKinds[kind], mistakes);
        }
        return plain_;
    }

  private:
    struct Found {
        RepeatedMistake places;
        char32_t first = 0;
    };

    static void report(const Found& found, const ForeignKind& kind, Mistakes& mistakes) {
        if (found.places.empty()) {
            return;
        }
        std::string shown = fmt::format("U+{:04X}", static_cast<std::uint32_t>(found.first));
        if (kind.visible) {
            std::string character;
            append_utf8(character, found.first);
            shown = fmt::format("{} ({})", character, shown);
        }
        mistakes.add(found.places.first(), fmt::format("{} {}{}; allowed: {}", shown, kind.name,
                                                       found.places.further_lines(), kind.allowed));
    }

    bool at_end() const { return at_ >= text_.size(); }
    std::size_t line_rest() const { return std::min(text_.find('\n', at_), text_.size()) - at_; }

    void copy(std::size_t count) {
        place_.pass(text_.substr(at_, count));
        plain_ += text_.substr(at_, count);
        at_ += count;
    }

    void replace(std::size_t count, Foreign kind, std::string_view replacement) {
        Found& found = found_[static_cast<std::size_t>(kind)];
        found.first = found.places.empty() ? utf8_character(text_.substr(at_)) : found.first;
        found.places.add(place_.where());
        place_.pass(kind == Foreign::line_end ? "\n" : text_.substr(at_, count));
        plain_ += replacement;
        at_ += count;
    }

    void copy_character() {
        const std::string_view rest = text_.substr(at_);
        const std::size_t length = utf8_length(rest);
        const auto kind = foreign_kind(utf8_character(rest));
        const std::string_view next = rest.substr(length);
        const bool number_follows =
            !next.empty() && (next[0] == '.' || (next[0] >= '0' && next[0] <= '9'));
        if (!kind || (kind == Foreign::dash && !number_follows)) {
            copy(length);
        } else if (kind == Foreign::double_quote || kind == Foreign::single_quote) {
            replace_quotes(length, *kind);
        } else {
            replace(length, *kind, description_of(*kind).replacement);
        }
    }

    /// Offset of the next quote of that kind in this line, or of its plain form.
    std::optional<std::size_t> next_quote(std::size_t from, Foreign kind) const {
        const std::size_t end = at_ + line_rest();
        while (from < end) {
            const std::string_view rest = text_.substr(from);
            if (rest.starts_with(description_of(kind).replacement) ||
                foreign_kind(utf8_character(rest)) == kind) {
                return from;
            }
            from += utf8_length(rest);
        }
        return std::nullopt;
    }

    /// At a typographic quote that begins a text.
    void replace_quotes(std::size_t length, Foreign kind) {
        const std::size_t begin = at_ + length;
        const auto end = next_quote(begin, kind);
        // A backslash means itself between single quotes only.
        const bool backslash = end && text_.substr(begin, *end - begin).find('\\') != text_.npos;
        const std::string_view quote = backslash ? "'" : description_of(kind).replacement;
        replace(length, kind, quote);
        if (end) {
            copy(*end - begin);
            close(kind, quote);
        }
    }

    /// At the quote that ends a text.
    void close(Foreign kind, std::string_view quote) {
        const std::size_t length = utf8_length(text_.substr(at_));
        if (foreign_kind(utf8_character(text_.substr(at_))) == kind) {
            replace(length, kind, quote);
        } else {
            place_.pass(text_[at_]);
            plain_ += quote;
            ++at_;
        }
    }

    /// At a plain quote. A text in one line may end with a typographic one.
    void copy_quoted(char quote) {
        const std::string three(3, quote);
        const bool lines = text_.substr(at_).starts_with(three);
        const std::string end = lines ? three : std::string(1, quote);
        const std::size_t limit = lines ? text_.size() : at_ + line_rest();
        std::size_t at = at_ + end.size();
        while (at < limit && !text_.substr(at).starts_with(end)) {
            at += quote == '"' && text_[at] == '\\' ? 2U : 1U;
        }
        if (at < limit) {
            copy(at + end.size() - at_);
            return;
        }
        const Foreign kind = quote == '"' ? Foreign::double_quote : Foreign::single_quote;
        const auto typographic = lines ? std::nullopt : next_quote(at_ + 1, kind);
        if (typographic && text_[*typographic] != quote) {
            copy(*typographic - at_);
            close(kind, end);
        } else {
            copy(limit - at_);
        }
    }

    std::string_view text_;
    std::size_t at_ = 0;
    TextPlace place_;
    std::string plain_;
    std::array<Found, kForeignKinds.size()> found_;
};

}  // namespace

std::string_view with_plain_characters(std::string_view text, std::string& converted,
                                       Mistakes& mistakes) {
    const auto is_usual = [](char c) {
        const auto byte = static_cast<unsigned char>(c);
        return byte < 0x80 && byte != '`' && byte != '\v' && byte != '\f';
    };
    if (std::ranges::all_of(text, is_usual)) {
        return text;
    }
    converted = PlainCharacters(text).write(mistakes);
    return converted;
}

}  // namespace tribus
