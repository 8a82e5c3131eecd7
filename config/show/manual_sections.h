#pragma once

#include <string>
#include <vector>

#include "config/keys/keys.h"

namespace tribus {

/// A part of the manual of the configuration, independent of the format.
struct ManualSection {
    bool inner = false;  ///< belongs to the section before
    std::string title;   ///< `[input.NAME]`
    /// Blocks as `blocks_of` reads them. Code is in backticks, a link is `[text](target)`.
    std::string text{};
    /// First part of the anchors of its keys: "input" makes "input-timeout".
    std::string anchor{};
    /// Whether inputs, outputs or both have the keys.
    SettingScope way = SettingScope::both;
    std::vector<Key> keys{};
    /// Whether the manual says for each key if inputs or outputs have it.
    bool shows_scope = false;
};

/// Returns the sections in the order of the page. Together they have every key.
std::vector<ManualSection> manual_sections();

}  // namespace tribus
