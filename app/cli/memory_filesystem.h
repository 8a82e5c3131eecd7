#pragma once

#include <linux/magic.h>
#include <sys/vfs.h>

#include <cstdint>

namespace tribus {

/// Whether a file system is in memory (tmpfs, ramfs): a write waits for no disk, and a start of the
/// machine forgets it. Pure.
inline bool is_in_memory(const struct statfs& system) {
    // The kernel's numbers have 32 bits; the type has a sign, and on some machines more bits.
    const auto type = static_cast<std::uint32_t>(system.f_type);
    return type == TMPFS_MAGIC || type == RAMFS_MAGIC;
}

}  // namespace tribus
