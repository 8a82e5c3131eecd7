#pragma once

#include <string>
#include <vector>

#include "app/doctor/facts/finding.h"
#include "app/doctor/facts/kernel_files.h"
#include "transports/links/can/can_interface.h"

namespace tribus::doctor {

/// The names of all CAN interfaces.
std::vector<std::string> can_interfaces(const KernelFiles& files);

/// Findings about what limits RC on this interface. If it is down or in bus-off, that is a problem
/// if the user `asked_for` it, else advice. Pure.
std::vector<Finding> judge_can(const CanInterface& interface, bool asked_for);

}  // namespace tribus::doctor
