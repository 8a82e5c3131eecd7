#pragma once

#include <cstring>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <tl/expected.hpp>

namespace tribus {

/// An error such as `/var/lib/tribus: No space left on device`. Pure.
inline tl::unexpected<std::string> file_error(const std::filesystem::path& path, int error) {
    return tl::unexpected(fmt::format("{}: {}", path.string(), std::strerror(error)));
}

}  // namespace tribus
