#include "app/ring_memory.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include <fmt/format.h>

namespace tribus {
namespace {

namespace fs = std::filesystem;
using Failed = tl::unexpected<std::string>;

constexpr const char* kFolder = "recorder";
constexpr const char* kLeft = "recorder-left";

Failed failed(const fs::path& path, int error) {
    return Failed(fmt::format("{}: {}", path.string(), std::strerror(error)));
}

}  // namespace

tl::expected<RingMemory, std::string> RingMemory::map(int flags, int fd, std::size_t bytes) {
    void* begin = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, flags | MAP_POPULATE, fd, 0);
    if (begin == MAP_FAILED) {
        return Failed(fmt::format("no memory for it: {}", std::strerror(errno)));
    }
    return RingMemory(static_cast<std::byte*>(begin), bytes);
}

tl::expected<RingMemory, std::string> RingMemory::anonymous(std::size_t bytes) {
    return map(MAP_PRIVATE | MAP_ANONYMOUS, -1, bytes);
}

tl::expected<RingMemory, std::string> RingMemory::in_file(const fs::path& path, std::size_t bytes) {
    const UniqueFd file(::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
    if (!file.valid()) {
        return failed(path, errno);
    }
    // All of it now: a page that cannot be had later would end the process.
    if (const int error = ::posix_fallocate(file.get(), 0, static_cast<off_t>(bytes)); error != 0) {
        ::unlink(path.c_str());
        return failed(path, error);
    }
    return map(MAP_SHARED, file.get(), bytes);
}

tl::expected<RingMemory, std::string> RingMemory::copy_of(const fs::path& path) {
    const UniqueFd file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    struct stat told {};
    if (!file.valid() || ::fstat(file.get(), &told) != 0) {
        return failed(path, errno);
    }
    return map(MAP_PRIVATE, file.get(), static_cast<std::size_t>(told.st_size));
}

RingMemory::~RingMemory() {
    if (begin_ != nullptr) {
        ::munmap(begin_, bytes_);
    }
}

fs::path RingHome::left() const {
    return path_.parent_path() / kLeft;
}

tl::expected<RingHome, std::string> RingHome::open(const fs::path& runtime_directory) {
    if (runtime_directory.empty()) {
        return Failed("no RUNTIME_DIRECTORY is set");
    }
    UniqueFd lock(::open(runtime_directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    struct statfs filesystem {};
    if (!lock.valid() || ::fstatfs(lock.get(), &filesystem) != 0) {
        return failed(runtime_directory, errno);
    }
    // On a disk, its driver could make the data thread wait.
    if (filesystem.f_type != TMPFS_MAGIC && filesystem.f_type != RAMFS_MAGIC) {
        return Failed(fmt::format("{} is not in memory (tmpfs)", runtime_directory.string()));
    }
    if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
        return Failed(fmt::format("another daemon uses {}", runtime_directory.string()));
    }
    const fs::path path = runtime_directory / kFolder;
    const fs::path left = runtime_directory / kLeft;
    std::error_code error;
    if (fs::exists(path, error)) {
        // The first crash of several tells most.
        if (fs::exists(left, error)) {
            fs::remove_all(path, error);
        } else {
            fs::rename(path, left, error);
        }
    }
    if (::mkdir(path.c_str(), 0700) != 0) {
        return failed(path, errno);
    }
    return RingHome(path, std::move(lock));
}

RingHome::~RingHome() {
    if (lock_.valid()) {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
}

}  // namespace tribus
