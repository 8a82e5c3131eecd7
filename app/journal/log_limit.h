#pragma once

#include <cstdint>
#include <string>

#include <fmt/format.h>

#include "core/counted.h"
#include "core/rate_limit.h"

/// Limits for log lines about one thing that keeps changing.
namespace tribus {

/// At most 6 lines in 30 s for each input, output, device and interface.
inline RateLimit log_limit() {
    constexpr unsigned kLinesPerWindow = 6;
    return {kLinesPerWindow, std::chrono::seconds(30)};
}

/// Appended to the first line after suppressed ones.
inline std::string swallowed_note(std::uint64_t swallowed) {
    return swallowed == 0
               ? ""
               : fmt::format(" ({} before this not logged)", counted(swallowed, "change"));
}

}  // namespace tribus
