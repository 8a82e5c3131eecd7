#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// The findings of `tribus doctor`.
namespace tribus::doctor {

enum class Severity : std::uint8_t {
    problem,  ///< what was asked for does not work, or not correctly, until it is fixed
    advice,   ///< it works, but better with this
    note,     ///< worth knowing; nothing to do
};
std::string_view severity_name(Severity severity);

/// One finding, written for the person who can act on it.
struct Finding {
    Severity severity = Severity::note;
    /// Stable, such as "port.permission"; for programs and for looking it up.
    std::string_view id;
    /// A device, an interface, or "machine".
    std::string where;
    std::string what;
    std::string why;  ///< what it means for RC; may be empty
    std::string fix;  ///< may be empty
    /// Shell commands, in this order.
    std::vector<std::string> commands{};
};

}  // namespace tribus::doctor
