#include "app/cli/replace_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
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

tl::expected<void, std::string> replace_file(const fs::path& file, std::string_view text,
                                             mode_t usual) {
    constexpr mode_t kPermissions = 0777;
    constexpr mode_t kOwnerOnly = 0600;
    const std::string name = file.filename().string();
    const std::string fresh = fmt::format(".{}.new", name);
    const UniqueFd folder = folder_of(file);
    struct stat before {};
    // A link gives nothing of what it leads to, rights of others least of all.
    const bool known = ::fstatat(folder.get(), name.c_str(), &before, AT_SYMLINK_NOFOLLOW) == 0 &&
                       S_ISREG(before.st_mode);
    const UniqueFd out = folder.valid() ? new_file(folder.get(), fresh, kOwnerOnly) : UniqueFd();
    if (known && ::fchown(out.get(), before.st_uid, before.st_gid) != 0) {
        std::ignore = ::fchown(out.get(), static_cast<uid_t>(-1), before.st_gid);
    }
    const bool written = out.valid() && write_all(out.get(), text) &&
                         ::fchmod(out.get(), known ? before.st_mode & kPermissions : usual) == 0 &&
                         ::fsync(out.get()) == 0 &&
                         ::renameat(folder.get(), fresh.c_str(), folder.get(), name.c_str()) == 0;
    if (!written) {
        const int why = errno;
        ::unlinkat(folder.get(), fresh.c_str(), 0);
        return file_error(file, why);
    }
    sync_folder(file.has_parent_path() ? file.parent_path() : ".");
    return {};
}

}  // namespace tribus
