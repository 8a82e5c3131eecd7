#pragma once

#include <optional>
#include <string_view>

#include "config/document.h"
#include "config/mistakes.h"
#include "core/setting.h"

namespace tribus {

/// `{ raw = [a, b], us = [c, d] }`, which is a table already. The line through the points must rise
/// such that neighbouring raw values stay apart, and keep the whole raw range inside a pulse.
/// Nothing, and mistakes added, if it does not.
std::optional<TwoPoints> read_scale(std::string_view key, const Value& value, Mistakes& mistakes);

/// Raw values of a scale are 11 bits wide.
inline constexpr double kMostRaw = 2047;

}  // namespace tribus
