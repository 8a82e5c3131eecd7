#include "config/language/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "transports/links/unique_fd.h"

namespace tribus {
namespace {

using Failed = tl::unexpected<std::string>;

tl::expected<std::string, std::string> read_to_end(int file, std::size_t expected,
                                                   std::size_t most) {
    constexpr std::size_t kBytesAtOnce = std::size_t{64} * 1024;
    std::string content;
    content.reserve(std::min(expected, most));
    while (content.size() < most) {
        const std::size_t before = content.size();
        content.resize(std::min(before + kBytesAtOnce, most));
        const ssize_t count = ::read(file, content.data() + before, content.size() - before);
        content.resize(before + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
        if (count == 0) {
            break;
        }
        if (count < 0 && errno != EINTR) {
            return Failed(std::strerror(errno));
        }
    }
    return content;
}

}  // namespace

tl::expected<std::string, std::string> read_file(const std::filesystem::path& path,
                                                 std::size_t most, FileKinds kinds) {
    // Opening a pipe would wait for a writer.
    const int nonblocking = kinds != FileKinds::any ? O_NONBLOCK : 0;
    const int follow = kinds == FileKinds::draft ? O_NOFOLLOW : 0;
    const UniqueFd file(
        ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | nonblocking | follow));
    struct stat told {};
    if (!file.valid() || ::fstat(file.get(), &told) != 0) {
        if (errno == ELOOP && kinds == FileKinds::draft) {
            return Failed("it is a symbolic link");
        }
        return Failed(std::strerror(errno));
    }
    if (S_ISDIR(told.st_mode)) {
        return Failed("it is a folder");
    }
    if (kinds != FileKinds::any && !S_ISREG(told.st_mode)) {
        return Failed("it is a device or a pipe, not a file");
    }
    if (kinds == FileKinds::draft && told.st_nlink != 1) {
        return Failed("it has another name too");
    }
    if (kinds == FileKinds::secret && (told.st_mode & S_IRWXO) != 0) {
        return Failed(fmt::format("its mode {:o} lets others use it; run: chmod o= {}",
                                  told.st_mode & 07777U, path.string()));
    }
    return read_to_end(file.get(), static_cast<std::size_t>(std::max<off_t>(told.st_size, 0)),
                       most);
}

}  // namespace tribus
