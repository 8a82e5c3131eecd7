#pragma once

#include <optional>

#include "config/document.h"
#include "config/mistakes.h"
#include "core/setting.h"

namespace tribus {

/// A table as the user wrote it, for a protocol to judge. Dates and times mean nothing anywhere:
/// each is a mistake.
std::optional<SettingTree> read_tree(std::string_view key, const Value& value, Mistakes& mistakes);

/// Reads the text file that the value names, from the folder of the configuration file.
std::optional<SettingFile> read_named_file(std::string_view key, const Value& value,
                                           Mistakes& mistakes);

}  // namespace tribus
