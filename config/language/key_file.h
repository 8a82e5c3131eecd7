#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "config/language/document.h"
#include "config/language/mistakes.h"
#include "core/setting.h"

namespace tribus {

/// Text for messages: the files that a key may name.
inline constexpr std::string_view kAllowedKeyFile =
    "the path of a file with 32 bytes or 64 hexadecimal digits, which only its owner and group may "
    "read";

/// Reads a key file: 32 bytes, or 64 hexadecimal digits. It must be out of reach for others than
/// its owner and group. The error is the reason, and shows nothing of what is in the file.
tl::expected<SecretKey, std::string> read_secret(const std::filesystem::path& path);

/// From now on this process opens no key file: a configuration that names one is read as if it was
/// there, with another secret. For programs that judge configurations and must not have their keys.
/// Call it before there are threads.
void forbid_secrets(bool forbidden = true);
bool are_secrets_forbidden();

/// Reads the key file that the value names, relative to the folder of the configuration file.
std::optional<KeyFile> read_key_file(std::string_view key, const Value& value, Mistakes& mistakes);

}  // namespace tribus
