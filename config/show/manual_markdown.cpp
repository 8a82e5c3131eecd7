#include <cctype>
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

/// Width of the other pages of docs/.
constexpr std::size_t kPageWidth = 120;

constexpr std::string_view kPageHead =
    "<!-- Made by tribus schema --format markdown -->\n\n"
    "# Configuration: every key\n\n"
    "The same in a terminal: `man tribus.toml`.\n";

/// The anchor that GitHub gives a heading without blanks.
std::string anchor_of(std::string_view heading) {
    std::string anchor;
    for (const char c : heading) {
        if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_') {
            anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        }
    }
    return anchor;
}

void append_contents(std::string& page) {
    page += "\n| table | is about |\n|---|---|\n";
    for (const Key& key : root_keys()) {
        const bool named = key.kind == KeyKind::named_tables;
        const std::string title = fmt::format("[{}{}]", key.name(), named ? ".NAME" : "");
        page += fmt::format("| [`{}`](#{}) | {} |\n", title, anchor_of(title), key.setting.help);
    }
}

void append_markdown_block(std::string& page, const ManualBlock& block) {
    page += '\n';
    if (block.kind == BlockKind::code) {
        page += "```toml\n";
        for (const std::string& line : block.texts) {
            page += line + '\n';
        }
        page += "```\n";
        return;
    }
    for (const std::string& text : block.texts) {
        page += block.kind == BlockKind::list ? paragraph("- ", "  ", text, kPageWidth)
                                              : paragraph("", "", text, kPageWidth);
    }
}

std::string_view scope_word(SettingScope scope) {
    return scope == SettingScope::input    ? "input"
           : scope == SettingScope::output ? "output"
                                           : "both";
}

/// Escapes bars, which would end the cell.
std::string cell(std::string_view text) {
    return replaced(std::string(text), "|", "\\|");
}

void append_key_table(std::string& page, const ManualSection& section) {
    const bool scoped = section.shows_scope;
    page += fmt::format("\n| key |{} type | range | default | meaning | example |\n",
                        scoped ? " in |" : "");
    page += fmt::format("|---|{}---|---|---|---|---|\n", scoped ? "---|" : "");
    for (const Key& key : section.keys) {
        const KeyWords words = words_of(key, section.way);
        page += fmt::format("| <a id=\"{0}-{1}\"></a>`{1}` |", section.anchor, key.name());
        page += scoped ? fmt::format(" {} |", scope_word(key.setting.scope)) : "";
        page += fmt::format(" {} | {} | {} | {} | `{}` |\n", words.type, cell(words.range),
                            cell(words.fallback), cell(words.meaning), cell(words.example));
    }
}

}  // namespace

std::string manual_markdown(const std::vector<ManualSection>& sections) {
    std::string page(kPageHead);
    append_contents(page);
    for (const ManualSection& section : sections) {
        page += fmt::format("\n{} {}\n", section.inner ? "###" : "##", section.title);
        for (const ManualBlock& block : blocks_of(section.text)) {
            append_markdown_block(page, block);
        }
        if (!section.keys.empty()) {
            append_key_table(page, section);
        }
    }
    return page;
}

}  // namespace tribus
