#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <tl/expected.hpp>

namespace tribus {

/// Which kinds of files `read_file` accepts.
enum class FileKinds : std::uint8_t {
    regular,  ///< anything but a regular file is refused, without waiting for it
    secret,   ///< as `regular`, and one that others than its owner and group may use is refused
    draft,    ///< as `regular`, and neither a link nor a file that has another name too
    any,      ///< a pipe, such as /dev/stdin, is read to its end
};

/// Content of a file, at most its first `most` bytes. The error is the reason why it cannot be
/// read, for a message that names the file.
tl::expected<std::string, std::string> read_file(const std::filesystem::path& path,
                                                 std::size_t most,
                                                 FileKinds kinds = FileKinds::regular);

}  // namespace tribus
