#pragma once

#include <linux/magic.h>
#include <sys/vfs.h>

#include <cstdint>
#include <filesystem>

namespace tribus {

/// Whether what is written there goes to memory (tmpfs, ramfs): a write waits for no disk, and a
/// start of the machine forgets it. False also if that cannot be told.
inline bool is_in_memory(const std::filesystem::path& path) {
    struct statfs system {};
    if (::statfs(path.c_str(), &system) != 0) {
        return false;
    }
    // The kernel's numbers have 32 bits; the type has a sign, and on some machines more bits.
    const auto type = static_cast<std::uint32_t>(system.f_type);
    return type == TMPFS_MAGIC || type == RAMFS_MAGIC;
}

}  // namespace tribus
