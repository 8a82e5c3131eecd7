#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// What `tribus doctor` finds out and says.
namespace tribus::doctor {

enum class Severity : std::uint8_t {
    problem,  ///< what was asked for does not work, or works wrongly, until it is mended
    advice,   ///< it works, and better with this
    note,     ///< worth knowing, nothing to do
};
std::string_view severity_name(Severity severity);

/// One thing that was found out, for the person who can do something about it.
struct Finding {
    Severity severity = Severity::note;
    /// Stable: "port.permission". For programs, and for who looks it up.
    std::string_view id;
    /// A device, an interface, "machine".
    std::string where;
    std::string what;
    std::string why;  ///< what it means for RC; may be empty
    std::string fix;  ///< may be empty
    /// Lines for a shell, in this order.
    std::vector<std::string> commands{};
};

}  // namespace tribus::doctor
