#pragma once

#include <string>
#include <vector>

#include "config/keys.h"

namespace tribus {

/// A part of the manual of the configuration, in no format yet.
struct ManualSection {
    bool inner = false;  ///< belongs to the section before
    std::string title;   ///< `[input.NAME]`
    /// Paragraphs, lists of `- ` and fenced blocks of TOML, with an empty line between them. Code
    /// stands in backticks, a link is `[text](target)`.
    std::string text{};
    /// First part of the anchors of its keys: "input" makes "input-timeout".
    std::string anchor{};
    /// Whether the keys stand in inputs, in outputs, or in both.
    SettingScope way = SettingScope::both;
    std::vector<Key> keys{};
    /// Each key tells by its scope whether it is for inputs or for outputs.
    bool shows_scope = false;
};

/// In the order of a reader. Together they have every key.
std::vector<ManualSection> manual_sections();

}  // namespace tribus
