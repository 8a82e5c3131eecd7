#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <tl/expected.hpp>

namespace tribus {

enum class FileKinds : std::uint8_t {
    regular,  ///< what is anything else is refused, and never waited for
    any,      ///< a pipe is read to its end, such as /dev/stdin
};

/// What a file holds, up to `most` bytes; the rest stays unread. The error is the reason why it
/// cannot be read, for a message that names the file.
tl::expected<std::string, std::string> read_file(const std::filesystem::path& path,
                                                 std::size_t most,
                                                 FileKinds kinds = FileKinds::regular);

}  // namespace tribus
