#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "app/doctor/finding.h"
#include "app/doctor/serial_facts.h"

namespace tribus::doctor {

enum class Ability : std::uint8_t { yes, no, unknown };
std::string_view ability_name(Ability ability);

/// What a port can do of one protocol, by what is known of its hardware and driver.
struct PortAbility {
    std::string_view protocol;  ///< "i.Bus", "SBUS", "fast SBUS", "sensor bus"
    Ability ability = Ability::unknown;
    std::string because;  ///< where it is not yes, or yes with a reservation
};

struct PortOpinion {
    std::string kind{};  ///< for a person: "USB adapter FTDI FT232R"
    std::vector<PortAbility> abilities{};
    std::vector<Finding> findings{};
};

/// What a port is good for and what stands in the way. What would be a problem for who asks for
/// this port is mere advice where it is one of all that there are. Pure.
PortOpinion judge_port(const SerialFacts& facts, bool asked_for);

}  // namespace tribus::doctor
