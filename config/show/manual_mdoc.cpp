#include <string>
#include <string_view>

#include <fmt/format.h>

#include "config/keys/words.h"
#include "config/show/manual.h"
#include "config/show/manual_sections.h"
#include "config/show/manual_text.h"
#include "config/show/paragraph.h"

namespace tribus {
namespace {

constexpr std::size_t kLineWidth = 80;

constexpr std::string_view kMdocHead = R"(.\" Made from the key table: tribus schema --format man
.Dd November 24, 2026
.Dt TRIBUS.TOML 5
.Os
.nh
.Sh NAME
.Nm tribus.toml
.Nd configuration of tribus
.Sh DESCRIPTION
)";

constexpr std::string_view kMdocFoot = R"(.Sh FILES
.Bl -tag -width Ds
.It Pa /etc/tribus/NAME.toml
Configurations of the service.
.It Pa /usr/share/doc/tribus/examples
Configurations to start from.
.It Pa /usr/share/doc/tribus/docs
The pages that are named above.
.It Pa /usr/share/tribus/tribus.schema.json
The schema for editors.
.El
.Sh SEE ALSO
.Xr tribus 1
)";

/// Escapes the characters that roff would interpret.
std::string escaped_for_roff(std::string_view text) {
    std::string roff;
    for (const char c : text) {
        switch (c) {
            case '\\':
                roff += "\\e";
                break;
            case '-':
                roff += "\\-";
                break;
            case '\'':
                roff += "\\(aq";
                break;
            case '^':
                roff += "\\(ha";
                break;
            case '~':
                roff += "\\(ti";
                break;
            default:
                roff += c;
        }
    }
    return roff;
}

/// Replaces each link by its text.
std::string without_links(std::string text) {
    for (std::size_t end = text.find("]("); end != std::string::npos; end = text.find("](")) {
        const std::size_t begin = text.rfind('[', end);
        const std::size_t close = text.find(')', end);
        text.replace(begin, close + 1 - begin, text.substr(begin + 1, end - begin - 1));
    }
    return text;
}

/// Prints code in bold. No line begins with a dot, which roff would take for a request.
std::string roff_text(std::string_view marked) {
    std::string roff;
    bool code = false;
    for (const char c : without_links(replaced(std::string(marked), "**", ""))) {
        if (c == '`') {
            code = !code;
            roff += code ? "\\fB" : "\\fP";
        } else {
            roff += escaped_for_roff(std::string_view(&c, 1));
        }
    }
    std::string lines = paragraph("", "", roff, kLineWidth);
    lines = replaced(std::move(lines), "\n.", "\n\\&.");
    return (lines.starts_with('.') ? "\\&" : "") + lines;
}

void append_mdoc_block(std::string& page, const ManualBlock& block) {
    if (block.kind == BlockKind::code) {
        page += ".Bd -literal -offset indent\n";
        for (const std::string& line : block.texts) {
            page += escaped_for_roff(line) + '\n';
        }
        page += ".Ed\n";
    } else if (block.kind == BlockKind::list) {
        page += ".Bl -bullet -compact\n";
        for (const std::string& text : block.texts) {
            page += ".It\n" + roff_text(text);
        }
        page += ".El\n";
    } else {
        page += roff_text(block.texts.front());
    }
}

std::string_view scope_words(const Key& key) {
    return key.setting.scope == SettingScope::input    ? "Inputs: "
           : key.setting.scope == SettingScope::output ? "Outputs: "
                                                       : "";
}

void append_mdoc_key(std::string& page, const Key& key, const ManualSection& section) {
    const KeyWords words = words_of(key, section.way);
    std::string facts = section.shows_scope ? std::string(scope_words(key)) : "";
    facts += words.type;
    facts += words.range.empty() ? "" : ", " + words.range;
    facts += key.setting.required ? "; required." : "; default: " + words.fallback + ".";
    page += fmt::format(".It Ic {}\n", key.name());
    page += fmt::format("{}.br\n{}.br\n{}", roff_text(facts), roff_text(words.meaning),
                        roff_text(fmt::format("Example: `{}`", words.example)));
}

void append_mdoc_section(std::string& page, const ManualSection& section) {
    bool first = true;
    for (const ManualBlock& block : blocks_of(section.text)) {
        page += first || block.kind != BlockKind::paragraph ? "" : ".Pp\n";
        append_mdoc_block(page, block);
        first = false;
    }
    if (section.keys.empty()) {
        return;
    }
    page += ".Bl -tag -width Ds\n";
    for (const Key& key : section.keys) {
        append_mdoc_key(page, key, section);
    }
    page += ".El\n";
}

}  // namespace

std::string manual_mdoc(const std::vector<ManualSection>& sections) {
    std::string page(kMdocHead);
    bool first = true;
    for (const ManualSection& section : sections) {
        // The first section has no keys: it is the description itself.
        if (!first) {
            page += fmt::format("{} {}\n", section.inner ? ".Ss" : ".Sh",
                                without_backticks(section.title));
        }
        append_mdoc_section(page, section);
        first = false;
    }
    page += kMdocFoot;
    return page;
}

}  // namespace tribus
