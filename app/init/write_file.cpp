#include "app/init/write_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/cli/replace_file.h"
#include "transports/links/unique_fd.h"

namespace tribus::init {
namespace {

namespace fs = std::filesystem;
using Refused = tl::unexpected<std::string>;

std::string exists_already(const std::string& path) {
    return fmt::format("{} exists; --force replaces it", path);
}

/// Delays signals such as Ctrl-C while the unfinished file exists.
class DelayedSignals {
  public:
    DelayedSignals() {
        sigset_t all;
        ::sigfillset(&all);
        ::pthread_sigmask(SIG_BLOCK, &all, &before_);
    }
    DelayedSignals(const DelayedSignals&) = delete;
    DelayedSignals& operator=(const DelayedSignals&) = delete;
    ~DelayedSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

  private:
    sigset_t before_{};
};

/// The file itself if the path is a symbolic link.
fs::path target_of(const std::string& path) {
    std::error_code none;
    const fs::path target = fs::weakly_canonical(path, none);
    return none || target.empty() ? fs::path(path) : target;
}

/// Creates the file, which must not exist. The error is an errno value.
tl::expected<UniqueFd, int> create_new(const std::string& path) {
    UniqueFd fd(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    return fd.valid() ? tl::expected<UniqueFd, int>(std::move(fd)) : tl::unexpected(errno);
}

/// Gives the finished file its name. Some file systems do not have RENAME_NOREPLACE.
bool give_name(const std::string& unfinished, const std::string& path, bool replace) {
    if (replace) {
        return ::rename(unfinished.c_str(), path.c_str()) == 0;
    }
    if (::renameat2(AT_FDCWD, unfinished.c_str(), AT_FDCWD, path.c_str(), RENAME_NOREPLACE) == 0) {
        return true;
    }
    const bool unsupported = errno == EINVAL || errno == ENOSYS;
    return unsupported && ::access(path.c_str(), F_OK) != 0 &&
           ::rename(unfinished.c_str(), path.c_str()) == 0;
}

/// A replaced file keeps its owner and mode.
void copy_owner_and_mode(const std::string& from, int to) {
    struct stat before {};
    if (::stat(from.c_str(), &before) == 0) {
        constexpr mode_t kModeBits = 0777;
        if (::fchown(to, before.st_uid, before.st_gid) == 0) {
            ::fchmod(to, before.st_mode & kModeBits);
        }
    }
}

}  // namespace

std::string file_problem(const std::string& path, bool replace) {
    struct stat there {};
    if (::lstat(path.c_str(), &there) == 0) {
        if (::stat(path.c_str(), &there) == 0 && !S_ISREG(there.st_mode)) {
            return fmt::format(
                "{} is not a regular file; give another name, or - for standard output", path);
        }
        if (!replace) {
            return exists_already(path);
        }
    }
    const fs::path folder = target_of(path).parent_path();
    const std::string name = folder.empty() ? "." : folder.string();
    if (::access(name.c_str(), W_OK | X_OK) != 0) {
        return fmt::format("{} cannot be written: {}: {}", path, name, std::strerror(errno));
    }
    return {};
}

tl::expected<void, std::string> write_file(const std::string& path, std::string_view text,
                                           bool replace) {
    const std::string target = target_of(path).string();
    const std::string unfinished = fmt::format("{}.unfinished-{}", target, ::getpid());
    const DelayedSignals delayed;
    const auto fd = create_new(unfinished);
    if (!fd) {
        return Refused(fmt::format("{} cannot be written: {}", path, std::strerror(fd.error())));
    }
    copy_owner_and_mode(target, fd->get());
    if (write_all(fd->get(), text) && ::fsync(fd->get()) == 0 &&
        give_name(unfinished, target, replace)) {
        return {};
    }
    const int error = errno;
    ::unlink(unfinished.c_str());
    return Refused(error == EEXIST
                       ? exists_already(path)
                       : fmt::format("{} cannot be written: {}", path, std::strerror(error)));
}

}  // namespace tribus::init
