#pragma once

#include <filesystem>
#include <string>
#include <system_error>

namespace tribus {

/// Whether two paths name one device, which may have several, such as those in /dev/serial/by-id.
/// Pure if both are the same, else it asks the file system.
inline bool is_same_device(const std::string& a, const std::string& b) {
    std::error_code missing;
    return std::filesystem::path(a).lexically_normal() ==
               std::filesystem::path(b).lexically_normal() ||
           std::filesystem::equivalent(a, b, missing);
}

}  // namespace tribus
