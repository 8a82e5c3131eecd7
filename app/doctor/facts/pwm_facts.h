#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "app/doctor/facts/finding.h"
#include "app/doctor/facts/kernel_files.h"
#include "app/doctor/facts/node_access.h"
#include "transports/links/pwm/pwm_chip.h"

namespace tribus::doctor {

/// A PWM chip, and its outputs that a program has taken.
struct PwmFacts {
    PwmChipFacts chip{};
    NodeAccess access{};
    std::vector<std::pair<std::size_t, PwmOutputFacts>> taken{};
};

/// All PWM chips.
std::vector<PwmFacts> look_at_pwm_chips(const KernelFiles& files);

/// Whether the name of a device is one of a PWM chip, there or not: "pwmchip0", also below
/// /sys/class/pwm, or the name of a driver of chips that are there.
bool names_pwm_chip(const KernelFiles& files, const std::string& device);

/// The chips with that name or driver; or the finding that there is none.
std::vector<PwmFacts> look_at_pwm_chip(const KernelFiles& files, const std::string& device);
Finding unknown_pwm_chip(const KernelFiles& files, const std::string& device);

/// Says why a configuration cannot use it, and what its outputs do. A hindrance is a problem if
/// the user `asked_for` this chip, else advice. Pure.
std::vector<Finding> judge_pwm(const PwmFacts& facts, bool asked_for);

}  // namespace tribus::doctor
