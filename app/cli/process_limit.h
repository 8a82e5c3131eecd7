#pragma once

#include <sys/resource.h>

#include <algorithm>

namespace tribus {

/// Lowers a limit of this process, such as RLIMIT_DATA, to at most `most`. False with errno if that
/// fails.
inline bool limit_process(int what, rlim_t most) {
    const auto resource = static_cast<__rlimit_resource>(what);
    rlimit limit{};
    if (::getrlimit(resource, &limit) != 0) {
        return false;
    }
    limit.rlim_max = std::min(limit.rlim_max, most);
    limit.rlim_cur = limit.rlim_max;
    return ::setrlimit(resource, &limit) == 0;
}

}  // namespace tribus
