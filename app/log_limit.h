#pragma once

#include <cstdint>
#include <string>

#include <fmt/format.h>

#include "core/counted.h"
#include "core/rate_limit.h"

/// How much the log may say of one thing that keeps changing.
namespace tribus {

/// A few lines a while for each input, output, device and interface.
inline RateLimit log_limit() {
    constexpr unsigned kLinesPerWindow = 6;
    return {kLinesPerWindow, std::chrono::seconds(30)};
}

/// For the end of the first line after a pause.
inline std::string swallowed_note(std::uint64_t swallowed) {
    return swallowed == 0
               ? ""
               : fmt::format(" ({} before this not logged)", counted(swallowed, "change"));
}

}  // namespace tribus
