#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "app/doctor/facts/finding.h"
#include "app/doctor/facts/serial_facts.h"

namespace tribus::doctor {

enum class Ability : std::uint8_t { yes, no, unknown };
std::string_view ability_name(Ability ability);

/// Whether a port can run a protocol, from what is known about its hardware and driver.
struct PortAbility {
    std::string_view protocol;  ///< "i.Bus", "SBUS", "fast SBUS", "sensor bus"
    Ability ability = Ability::unknown;
    std::string because;  ///< the reason, unless yes without reservation
};

/// What is known about a port, for its report.
struct PortOpinion {
    std::string kind{};  ///< for people: "USB adapter FTDI FT232R"
    std::vector<PortAbility> abilities{};
    std::vector<Finding> findings{};
};

/// What a port can do and what prevents it. A hindrance is a problem if the user `asked_for` this
/// port, else advice. Pure.
PortOpinion judge_port(const SerialFacts& facts, bool asked_for);

}  // namespace tribus::doctor
