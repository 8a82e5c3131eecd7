#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/quantity.h"
#include "core/setting.h"
#include "core/time.h"

/// Values as they are written in the configuration, both ways. Pure.
namespace tribus {

/// In the largest unit that needs no fraction: "14ms", "1500us". Parses back to the same.
std::string format_duration(Duration duration);

/// "2000us/s": microseconds of pulse a second.
std::optional<double> parse_slew(std::string_view text);
std::string format_slew(double microseconds_per_second);

/// The shortest text that reads back as the same number; whole numbers without a point.
std::string format_number(double number);

/// The default of a row whose `fallback` is not empty, which is checked by a test over all rows.
SettingValue default_of(const Setting& setting);

/// The text of a default without the quotes around it.
std::string_view unquoted_fallback(const Setting& setting);

/// Whether a row names a network interface, in whatever table it stands.
inline bool names_interface(const Setting& setting) {
    return setting.key == "interface";
}
/// As Linux allows them: 1 to 15 characters, none of them a blank, "/" or ":"; not "." or "..".
bool is_interface_name(std::string_view text);

double seconds_of(Duration duration);

}  // namespace tribus
