#pragma once

#include <vector>

#include "app/doctor/finding.h"
#include "app/doctor/machine_facts.h"

namespace tribus::doctor {

/// Findings about what limits RC on this machine. Pure.
std::vector<Finding> judge_machine(const MachineFacts& facts);

}  // namespace tribus::doctor
