#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "core/setting.h"

namespace tribus {

/// Group of key files, which the service joins. It is no user's own: neither operators nor the page
/// nor the bridge need keys.
inline constexpr std::string_view kKeyGroup = "tribus-keys";

/// 16 hexadecimal digits in groups of four, by which people compare the keys of two boards: the
/// first 64 bits of SHA-256 over "tribus key fingerprint" and the secret. The secret is random, so
/// nobody can learn it from them.
std::string fingerprint(const SecretKey& secret);

/// A key file that was made.
struct MadeKeyFile {
    SecretKey secret{};
    bool service_reads = false;  ///< it has the group of key files
};

/// Makes a file with a new random secret, as 64 hexadecimal digits. Only its owner may read it. If
/// root makes it on a machine that has `kKeyGroup`, that group may read it too. A file that
/// is there stays as it is, and is an error. The error is a sentence for the user.
tl::expected<MadeKeyFile, std::string> make_key_file(const std::filesystem::path& path);

}  // namespace tribus
