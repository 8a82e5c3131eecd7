#pragma once

#include <string>
#include <vector>

#include "config/show/manual_sections.h"

namespace tribus::test {

/// A section with every kind of block and no key.
inline ManualSection hand_made_text() {
    return {.title = "The file",
            .text =
                "One `code` and [a link](a.md#b), **bold**; [x] and [y](z).\n\n"
                "Second.\n\n"
                "- item one\n  goes on\n- `.two`\n\n"
                "```toml\n[a-b]\n\nc = 'x' ^ ~ \\\n```\n"
                ".dot"};
}

/// A section with keys of the most usual kinds.
inline ManualSection hand_made_keys() {
    return {
        .title = "`[input.NAME]`",
        .text = "Text.",
        .anchor = "input",
        .way = SettingScope::output,
        .keys = {
            {.setting = {.key = "timeout",
                         .type = SettingType::duration,
                         .fallback = "\"100ms\"",
                         .least = 0.005,
                         .most = 10,
                         .scope = SettingScope::input,
                         .help = "Lost after this | that",
                         .example = "\"250ms\"",
                         .output_example = "\"260ms\""}},
            {.setting = {
                 .key = "name", .required = true, .help = "Its `name`", .example = "\"a-b\""}}}};
}

/// A section inside of another one, whose keys say whether inputs or outputs have them.
inline ManualSection hand_made_scopes() {
    const auto key = [](std::string_view name, SettingScope scope) {
        return Key{.setting = {.key = name, .scope = scope, .help = "Help", .example = "\"x\""}};
    };
    return {.inner = true,
            .title = "`sbus`",
            .anchor = "sbus",
            .keys = {key("a", SettingScope::input), key("b", SettingScope::output),
                     key("c", SettingScope::both)},
            .shows_scope = true};
}

inline std::vector<ManualSection> hand_made_manual() {
    return {hand_made_text(), hand_made_keys(), hand_made_scopes()};
}

}  // namespace tribus::test
