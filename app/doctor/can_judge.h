#pragma once

#include <string>
#include <vector>

#include "app/doctor/finding.h"
#include "app/doctor/kernel_files.h"
#include "transports/links/can_interface.h"

namespace tribus::doctor {

/// The names of all network interfaces that are CAN.
std::vector<std::string> can_interfaces(const KernelFiles& files);

/// What of the interface makes RC over it worse. Whether it is down or off is a problem for who
/// asks for it, and else advice. Pure.
std::vector<Finding> judge_can(const CanInterface& interface, bool asked_for);

}  // namespace tribus::doctor
