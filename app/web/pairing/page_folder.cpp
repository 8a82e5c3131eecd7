#include "app/web/pairing/page_folder.h"

#include <fcntl.h>
#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <optional>

#include <fmt/format.h>

#include "app/cli/file_error.h"
#include "app/cli/replace_file.h"
#include "config/language/read_file.h"
#include "transports/links/unique_fd.h"

namespace tribus::web {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kPermissions = 07777;
constexpr mode_t kRootOnly = 0600;

/// The group of the page; nothing if this is not root, or the package is not installed. Its folder
/// may be gone.
std::optional<gid_t> group_of_page(const fs::path& state) {
    struct stat page {};
    if (::geteuid() != 0) {
        return std::nullopt;
    }
    if (::stat(state.c_str(), &page) == 0) {
        return page.st_uid == 0 ? std::nullopt : std::optional(page.st_gid);
    }
    const struct group* const named = ::getgrnam(state.filename().c_str());
    return named == nullptr ? std::nullopt : std::optional(named->gr_gid);
}

struct Rights {
    gid_t group = 0;
    mode_t mode = 0;
};

/// What the file of `give` says; nothing if there is none, or not root wrote it.
std::optional<Rights> kept_rights(const fs::path& file) {
    constexpr std::size_t kMostBytes = 64;
    struct stat told {};
    unsigned group = 0;
    unsigned mode = 0;
    if (::lstat(file.c_str(), &told) != 0 || told.st_uid != 0 ||
        (told.st_mode & kPermissions) != kRootOnly) {
        return std::nullopt;
    }
    const auto text = read_file(file, kMostBytes, FileKinds::draft);
    return text && std::sscanf(text->c_str(), "%u %o", &group, &mode) == 2
               ? std::optional(Rights{group, mode})
               : std::nullopt;
}

}  // namespace

tl::expected<void, std::string> PageFolder::give() const {
    const auto page = group_of_page(state);
    if (!page) {
        return {};
    }
    const UniqueFd folder(
        ::open(configurations.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    struct stat before {};
    if (!folder.valid() || ::fstat(folder.get(), &before) != 0) {
        return file_error(configurations, errno);
    }
    if (before.st_gid == *page && (before.st_mode & S_IWGRP) != 0) {
        return {};
    }
    const gid_t group = before.st_gid == *page ? 0 : before.st_gid;
    auto kept = replace_file(
        kept_in(), fmt::format("{} {:o}\n", group, before.st_mode & kPermissions), kRootOnly);
    if (!kept) {
        return kept;
    }
    if (::fchown(folder.get(), static_cast<uid_t>(-1), *page) != 0 ||
        ::fchmod(folder.get(), (before.st_mode & kPermissions) | S_IWGRP) != 0) {
        return file_error(configurations, errno);
    }
    return {};
}

tl::expected<void, std::string> PageFolder::take_back() const {
    const auto page = group_of_page(state);
    struct stat now {};
    if (!page) {
        return {};
    }
    const UniqueFd folder(
        ::open(configurations.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (!folder.valid() || ::fstat(folder.get(), &now) != 0) {
        return file_error(configurations, errno);
    }
    if (now.st_gid != *page) {
        return {};
    }
    // Where nothing was kept, as the package makes the folder: for the group root.
    const mode_t others = now.st_mode & kPermissions & ~mode_t{S_IRWXG};
    const Rights before =
        kept_rights(kept_in()).value_or(Rights{0, now.st_mode & ~mode_t{S_IWGRP}});
    if (::fchmod(folder.get(), others | (before.mode & S_IRWXG)) != 0 ||
        ::fchown(folder.get(), static_cast<uid_t>(-1), before.group) != 0) {
        return file_error(configurations, errno);
    }
    ::unlink(kept_in().c_str());
    return {};
}

}  // namespace tribus::web
