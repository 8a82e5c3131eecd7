#pragma once

#include <string>

#include <fmt/format.h>

#include "config/schema/schema.h"

namespace tribus {

/// End of a sentence about a port at which nothing comes: "; `tribus doctor can0` looks at the
/// interface". Empty where doctor does not know such places.
inline std::string doctor_hint(const PortConfig& port) {
    const std::string_view does = port.medium->silence.doctor;
    return does.empty() ? std::string() : fmt::format("; `tribus doctor {}` {}", port.device, does);
}

}  // namespace tribus
