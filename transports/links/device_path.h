#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <string>

namespace tribus {

/// The same text for all paths of one device, which may have several, such as those in
/// /dev/serial/by-id. Asks the file system. A path that is absent is its own identity; no such path
/// begins with two slashes.
inline std::string device_identity(const std::string& path) {
    struct stat told {};
    if (::stat(path.c_str(), &told) != 0) {
        return std::filesystem::path(path).lexically_normal();
    }
    return "//" + std::to_string(told.st_dev) + ':' + std::to_string(told.st_ino);
}

}  // namespace tribus
