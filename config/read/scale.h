#pragma once

#include <optional>
#include <string_view>

#include "config/language/document.h"
#include "config/language/mistakes.h"
#include "core/setting.h"

namespace tribus {

/// Reads `{ raw = [a, b], us = [c, d] }`; `value` must be a table. The line through the points must
/// rise so that neighbouring raw values stay distinct, and the whole raw range must fit into a
/// Pulse. Otherwise adds mistakes and returns `nullopt`.
std::optional<TwoPoints> read_scale(std::string_view key, const Value& value, Mistakes& mistakes);

}  // namespace tribus
