#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/quantity.h"
#include "core/setting.h"
#include "core/time.h"

/// Converts values from and to their notation in the configuration. Pure.
namespace tribus {

/// Formats in the largest unit without a fraction: "14ms", "1500us". Parses back to the same value.
std::string format_duration(Duration duration);

/// Parses a rate of change such as "2000us/s", in microseconds of pulse per second.
std::optional<double> parse_slew(std::string_view text);
std::string format_slew(double microseconds_per_second);

/// The shortest text that reads back as the same number. Whole numbers have no decimal point.
std::string format_number(double number);

/// The `fallback` of a row, which must have one. A test checks all rows.
SettingValue default_of(const Setting& setting);

/// A value as it stands in a file; empty for files, trees and scales of two points.
std::string written(SettingType type, const SettingValue& value);

/// Whether the row is the name of a network interface.
inline bool names_interface(const Setting& setting) {
    return setting.key == "interface";
}
/// Names that Linux accepts: 1 to 15 characters without blanks, "/" and ":"; not "." or "..".
bool is_interface_name(std::string_view text);

double seconds_of(Duration duration);

}  // namespace tribus
