#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "config/keys/keys.h"
#include "config/language/document.h"
#include "config/language/mistakes.h"
#include "core/setting.h"

namespace tribus {

/// Checks a value against its row: type, range, choices. Adds a mistake and returns `nullopt` if it
/// is not allowed. Pulses (microseconds) and slews (microseconds per second) are doubles.
std::optional<SettingValue> read_value(const Key& key, const Value& value, Mistakes& mistakes);

/// The values that the row allows, for messages: "a whole number from 1 to 99".
std::string allowed_values(const Key& key);

/// Reads a pulse in microseconds, within kLeastPulse and kMostPulse.
std::optional<double> read_pulse(std::string_view key, const Value& value, Mistakes& mistakes);

/// A number from `least` to `most`, whole or not. Rejects not-a-number and infinities.
std::optional<double> number_within(const Value& value, double least, double most);

}  // namespace tribus
