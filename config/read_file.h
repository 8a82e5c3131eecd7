#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <tl/expected.hpp>

namespace tribus {

/// What a file holds, up to `most` bytes; the rest stays unread. The error is the reason why it
/// cannot be read, for a message that names the file.
tl::expected<std::string, std::string> read_file(const std::filesystem::path& path,
                                                 std::size_t most);

}  // namespace tribus
