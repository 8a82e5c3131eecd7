#pragma once

#include <optional>
#include <string_view>

#include "config/language/document.h"
#include "config/language/mistakes.h"
#include "core/setting.h"

namespace tribus {

/// Reads the key file that the value names, relative to the folder of the configuration file: 32
/// bytes, or 64 hexadecimal digits. It must be out of reach for others than its owner and group. No
/// message shows what is in it.
std::optional<KeyFile> read_key_file(std::string_view key, const Value& value, Mistakes& mistakes);

}  // namespace tribus
