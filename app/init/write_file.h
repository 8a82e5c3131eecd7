#pragma once

#include <string>
#include <string_view>

#include <tl/expected.hpp>

/// The file that `tribus init` writes.
namespace tribus::init {

/// Why the file cannot be written: it exists and must not be replaced, it is not a regular file, or
/// its folder cannot be written. Empty if no reason is known yet.
std::string file_problem(const std::string& path, bool replace);

/// Writes the file, or replaces it, completely or not at all. Follows a symbolic link. The error is
/// a sentence. Blocks until the file is on the disk.
tl::expected<void, std::string> write_file(const std::string& path, std::string_view text,
                                           bool replace);

}  // namespace tribus::init
