#pragma once

#include <optional>
#include <string_view>

#include "core/time.h"

/// Numbers with a unit behind them, as people write them. Pure and reentrant.
namespace tribus {

struct Quantity {
    double number = 0;
    std::string_view unit;
};

/// Digits, perhaps a point and digits, then the unit. No sign, exponent or space.
std::optional<Quantity> parse_quantity(std::string_view text);

/// "500us", "14ms", "1.5s": digits, perhaps a fraction, a unit, nothing else. Rounded to whole
/// nanoseconds; nothing for anything else, and beyond a year.
std::optional<Duration> parse_duration(std::string_view text);

}  // namespace tribus
