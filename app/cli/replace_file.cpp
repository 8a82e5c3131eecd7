#include "app/cli/replace_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <tuple>

#include <fmt/format.h>

#include "app/cli/file_error.h"
#include "app/cli/new_file.h"
#include "transports/links/unique_fd.h"

namespace tribus {
namespace {

namespace fs = std::filesystem;

void sync_folder(const fs::path& folder) {
    const UniqueFd directory(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    ::fsync(directory.get());
}

}  // namespace

bool write_all(int descriptor, std::string_view text) {
    while (!text.empty()) {
        const ssize_t count = ::write(descriptor, text.data(), text.size());
        if (count < 0 && errno != EINTR) {
            return false;
        }
        text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    }
    return true;
}

fs::path linked_file(const fs::path& file) {
    std::error_code error;
    fs::path target = fs::weakly_canonical(file, error);
    return error ? file : target;
}

fs::path successor_of(const fs::path& file) {
    return file.parent_path() / fmt::format(".{}.new", file.filename().string());
}

void remove_successor(const fs::path& file) {
    ::unlinkat(folder_of(file).get(), successor_of(file).filename().c_str(), 0);
}

tl::expected<void, std::string> write_successor(const fs::path& file, std::string_view text,
                                                mode_t usual) {
    constexpr mode_t kPermissions = 0777;
    constexpr mode_t kOwnerOnly = 0600;
    const UniqueFd folder = folder_of(file);
    struct stat before {};
    // A link gives nothing of what it leads to, rights of others least of all.
    const bool known =
        ::fstatat(folder.get(), file.filename().c_str(), &before, AT_SYMLINK_NOFOLLOW) == 0 &&
        S_ISREG(before.st_mode);
    const UniqueFd out = folder.valid()
                             ? new_file(folder.get(), successor_of(file).filename(), kOwnerOnly)
                             : UniqueFd();
    if (known && ::fchown(out.get(), before.st_uid, before.st_gid) != 0) {
        std::ignore = ::fchown(out.get(), static_cast<uid_t>(-1), before.st_gid);
    }
    const bool written = out.valid() && write_all(out.get(), text) &&
                         ::fchmod(out.get(), known ? before.st_mode & kPermissions : usual) == 0 &&
                         ::fsync(out.get()) == 0;
    if (!written) {
        const int why = errno;
        remove_successor(file);
        return file_error(file, why);
    }
    return {};
}

tl::expected<void, std::string> put_successor_in_place(const fs::path& file) {
    const UniqueFd folder = folder_of(file);
    if (::renameat(folder.get(), successor_of(file).filename().c_str(), folder.get(),
                   file.filename().c_str()) != 0) {
        const int why = errno;
        remove_successor(file);
        return file_error(file, why);
    }
    sync_folder(file.has_parent_path() ? file.parent_path() : ".");
    return {};
}

tl::expected<void, std::string> replace_file(const fs::path& file, std::string_view text,
                                             mode_t usual) {
    return write_successor(file, text, usual).and_then([&] {
        return put_successor_in_place(file);
    });
}

}  // namespace tribus
