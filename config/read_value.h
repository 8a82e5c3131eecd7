#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "config/document.h"
#include "config/mistakes.h"
#include "core/setting.h"

namespace tribus {

/// A value checked against its row: type, range, choices. Nothing, and a mistake added, if it is
/// not allowed. A number for a pulse is a double, in microseconds; so is one for a slew.
std::optional<SettingValue> read_value(const Setting& setting, const Value& value,
                                       Mistakes& mistakes);

/// What the row allows, for a person: "a whole number from 1 to 99".
std::string allowed_values(const Setting& setting);

/// A number of microseconds in the limits that all given pulses share.
std::optional<double> read_pulse(std::string_view key, const Value& value, Mistakes& mistakes);

/// A number from `least` to `most`; whole numbers count, not-a-number and infinities do not.
std::optional<double> number_within(const Value& value, double least, double most);

}  // namespace tribus
