#pragma once

#include <cstdint>

namespace tribus {

/// The nearest whole number; halves go away from zero, as std::llround does it. `value` lies within
/// +-2^62. The mathematics library is not among what real time locks into memory
/// (app/data_path.ld), so the data path rounds with this. Pure.
constexpr std::int64_t nearest_whole(double value) {
    const auto towards_zero = static_cast<std::int64_t>(value);
    const double rest = value - static_cast<double>(towards_zero);
    return towards_zero + (rest >= 0.5 ? 1 : 0) - (rest <= -0.5 ? 1 : 0);
}

}  // namespace tribus
