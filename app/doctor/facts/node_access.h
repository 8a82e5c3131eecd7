#pragma once

#include <string>

#include "app/doctor/facts/kernel_files.h"

namespace tribus::doctor {

/// Whether this user may open a file of the kernel.
struct NodeAccess {
    bool exists = false;
    bool may_open = false;
    std::string group{};  ///< of the file
};

/// `mode`: R_OK, W_OK or both. `path` has no leading slash.
NodeAccess access_to(const KernelFiles& files, const std::string& path, int mode);

}  // namespace tribus::doctor
