#pragma once

#include <optional>
#include <string_view>

#include "core/time.h"

/// Numbers followed by a unit, as users write them. Pure and reentrant.
namespace tribus {

struct Quantity {
    double number = 0;
    std::string_view unit;
};

/// Reads digits, an optional decimal point with digits, then the unit. Sign, exponent and space are
/// not allowed.
std::optional<Quantity> parse_quantity(std::string_view text);

/// Reads "500us", "14ms" or "1.5s": digits, an optional fraction, and one of these units. Rounds to
/// whole nanoseconds. Returns nothing for any other text and for more than 366 days.
std::optional<Duration> parse_duration(std::string_view text);

}  // namespace tribus
