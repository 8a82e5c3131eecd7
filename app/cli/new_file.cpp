#include "app/cli/new_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tribus {

UniqueFd folder_of(const std::filesystem::path& file) {
    const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
    return UniqueFd(::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
}

UniqueFd new_file(int folder, const std::string& name, mode_t mode) {
    ::unlinkat(folder, name.c_str(), 0);
    UniqueFd made(
        ::openat(folder, name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode));
    // The umask of the caller has no part in it.
    if (!made.valid() || (give_to_owner(folder, made.get()) && ::fchmod(made.get(), mode) == 0)) {
        return made;
    }
    ::unlinkat(folder, name.c_str(), 0);
    return {};
}

bool give_to_owner(int folder, int made) {
    struct stat owner {};
    return ::geteuid() != 0 ||
           (::fstat(folder, &owner) == 0 && ::fchown(made, owner.st_uid, owner.st_gid) == 0);
}

}  // namespace tribus
