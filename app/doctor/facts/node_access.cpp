#include "app/doctor/facts/node_access.h"

#include <fcntl.h>
#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstddef>

namespace tribus::doctor {
namespace {

std::string group_name(gid_t group) {
    constexpr std::size_t kMostText = 4096;
    std::array<char, kMostText> text{};
    struct group entry {};
    struct group* found = nullptr;
    const bool known = ::getgrgid_r(group, &entry, text.data(), text.size(), &found) == 0;
    return known && found != nullptr ? entry.gr_name : std::to_string(group);
}

}  // namespace

NodeAccess access_to(const KernelFiles& files, const std::string& path, int mode) {
    const std::string file = files.at(path);
    struct stat node {};
    if (::stat(file.c_str(), &node) != 0) {
        return {};
    }
    return {.exists = true,
            .may_open = ::faccessat(AT_FDCWD, file.c_str(), mode, AT_EACCESS) == 0,
            .group = group_name(node.st_gid)};
}

}  // namespace tribus::doctor
