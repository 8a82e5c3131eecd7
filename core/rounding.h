#pragma once

#include <cstdint>

namespace tribus {

/// The nearest whole number; halves go away from zero, as in std::llround. `value` must lie within
/// +-2^62. The data path uses this because libm is not locked into memory (app/data_path.ld). Pure.
constexpr std::int64_t nearest_whole(double value) {
    const auto towards_zero = static_cast<std::int64_t>(value);
    const double rest = value - static_cast<double>(towards_zero);
    return towards_zero + (rest >= 0.5 ? 1 : 0) - (rest <= -0.5 ? 1 : 0);
}

}  // namespace tribus
