#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace tribus {

/// `1 input`, `2 inputs`. Give `plural` for a noun whose plural is not formed with s.
inline std::string counted(std::uint64_t count, std::string_view noun,
                           std::string_view plural = {}) {
    const bool one = count == 1;
    return std::to_string(count)
        .append(" ")
        .append(one || plural.empty() ? noun : plural)
        .append(one || !plural.empty() ? "" : "s");
}

}  // namespace tribus
