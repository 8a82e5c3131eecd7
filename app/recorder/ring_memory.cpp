#include "app/recorder/ring_memory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include <fmt/format.h>

#include "app/cli/file_error.h"
#include "app/cli/memory_filesystem.h"
#include "app/journal/log.h"

namespace tribus {
namespace {

namespace fs = std::filesystem;
using Failed = tl::unexpected<std::string>;

constexpr const char* kRingFolder = "recorder";
constexpr const char* kLeft = "recorder-left";
/// Data that a process has begun to read.
constexpr const char* kTaken = "recorder-taken";

/// True for any kind of file, also for a dangling link.
bool has_entry(const fs::path& path) {
    std::error_code error;
    return fs::symlink_status(path, error).type() != fs::file_type::not_found;
}

}  // namespace

tl::expected<RingMemory, std::string> RingMemory::map(int flags, int fd, std::size_t bytes) {
    void* begin = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, flags | MAP_POPULATE, fd, 0);
    if (begin == MAP_FAILED) {
        return Failed(fmt::format("cannot get memory: {}", std::strerror(errno)));
    }
    return RingMemory(static_cast<std::byte*>(begin), bytes);
}

tl::expected<RingMemory, std::string> RingMemory::anonymous(std::size_t bytes) {
    return map(MAP_PRIVATE | MAP_ANONYMOUS, -1, bytes);
}

tl::expected<RingMemory, std::string> RingMemory::in_file(const fs::path& path, std::size_t bytes) {
    const UniqueFd file(::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
    if (!file.valid()) {
        return file_error(path, errno);
    }
    // Allocates all pages now: a page that is missing later would kill the process.
    if (const int error = ::posix_fallocate(file.get(), 0, static_cast<off_t>(bytes)); error != 0) {
        ::unlink(path.c_str());
        return file_error(path, error);
    }
    return map(MAP_SHARED, file.get(), bytes);
}

tl::expected<RingMemory, std::string> RingMemory::copy_of(const fs::path& path, std::size_t most) {
    const UniqueFd file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    struct stat told {};
    if (!file.valid() || ::fstat(file.get(), &told) != 0) {
        return file_error(path, errno);
    }
    if (!S_ISREG(told.st_mode)) {
        return Failed(fmt::format("{} is not a file", path.string()));
    }
    if (told.st_size <= 0 || static_cast<std::uintmax_t>(told.st_size) > most) {
        return Failed(fmt::format("{} has a wrong size, {} bytes", path.string(), told.st_size));
    }
    // Read, not mapped: a mapped file that shrinks would kill the process.
    auto memory = anonymous(static_cast<std::size_t>(told.st_size));
    for (std::size_t at = 0; memory && at < memory->bytes_;) {
        const ssize_t count = ::read(file.get(), memory->begin_ + at, memory->bytes_ - at);
        if (count == 0 || (count < 0 && errno != EINTR)) {
            return file_error(path, count == 0 ? EIO : errno);
        }
        at += count > 0 ? static_cast<std::size_t>(count) : 0;
    }
    return memory;
}

RingMemory::~RingMemory() {
    if (begin_ != nullptr) {
        ::munmap(begin_, bytes_);
    }
}

std::optional<fs::path> RingDirectory::take_left() const {
    const fs::path left = path_.parent_path() / kLeft;
    const fs::path taken = path_.parent_path() / kTaken;
    std::error_code error;
    if (!has_entry(left)) {
        return std::nullopt;
    }
    fs::rename(left, taken, error);
    return error ? std::nullopt : std::optional(taken);
}

void RingDirectory::remove_left() const {
    std::error_code ignored;
    fs::remove_all(path_.parent_path() / kTaken, ignored);
}

void RingDirectory::put_left_back() const {
    std::error_code ignored;
    fs::rename(path_.parent_path() / kTaken, path_.parent_path() / kLeft, ignored);
}

tl::expected<RingDirectory, std::string> RingDirectory::open(const fs::path& runtime_directory) {
    if (runtime_directory.empty()) {
        return Failed("no RUNTIME_DIRECTORY is set");
    }
    UniqueFd lock(::open(runtime_directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    struct statfs system {};
    if (!lock.valid() || ::fstatfs(lock.get(), &system) != 0) {
        return file_error(runtime_directory, errno);
    }
    // On a disk, the driver could delay the data thread.
    if (!is_in_memory(system)) {
        return Failed(fmt::format("{} is not in memory (tmpfs)", runtime_directory.string()));
    }
    if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
        return Failed(fmt::format("another daemon uses {}", runtime_directory.string()));
    }
    const fs::path path = runtime_directory / kRingFolder;
    const fs::path left = runtime_directory / kLeft;
    std::error_code error;
    const fs::path taken = runtime_directory / kTaken;
    if (has_entry(taken)) {
        log_warning(
            "recorder: the process before this one ended while it wrote the recording of a crash; "
            "that recording is lost");
        fs::remove_all(taken, error);
    }
    if (has_entry(path)) {
        // The first of several crashes tells most.
        if (has_entry(left)) {
            fs::remove_all(path, error);
        } else {
            fs::rename(path, left, error);
        }
    }
    if (::mkdir(path.c_str(), 0700) != 0) {
        return file_error(path, errno);
    }
    return RingDirectory(path, std::move(lock));
}

RingDirectory::~RingDirectory() {
    if (lock_.valid()) {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
}

}  // namespace tribus
