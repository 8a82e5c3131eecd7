#pragma once

#include <optional>

#include "config/language/document.h"
#include "config/language/mistakes.h"
#include "core/setting.h"

namespace tribus {

/// Reads a table as it is, for the protocol to check. Dates and times are mistakes.
std::optional<SettingTree> read_tree(std::string_view key, const Value& value, Mistakes& mistakes);

/// Reads the text file that the value names, relative to the folder of the configuration file.
std::optional<SettingFile> read_named_file(std::string_view key, const Value& value,
                                           Mistakes& mistakes);

}  // namespace tribus
