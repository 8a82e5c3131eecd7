#include "config/read_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

namespace tribus {

tl::expected<std::string, std::string> read_file(const std::filesystem::path& path,
                                                 std::size_t most) {
    std::error_code error;
    // A folder opens and only fails when it is read.
    if (std::filesystem::is_directory(path, error)) {
        return tl::unexpected<std::string>("it is a folder");
    }
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        return tl::unexpected<std::string>(std::strerror(errno));
    }
    std::string content(most, '\0');
    file.read(content.data(), static_cast<std::streamsize>(content.size()));
    if (file.bad()) {
        return tl::unexpected<std::string>(std::strerror(errno));
    }
    content.resize(static_cast<std::size_t>(file.gcount()));
    return content;
}

}  // namespace tribus
