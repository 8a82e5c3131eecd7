#pragma once

#include <vector>

#include "app/doctor/facts/finding.h"
#include "app/doctor/facts/machine_facts.h"

namespace tribus::doctor {

/// Findings about what limits RC on this machine. Pure.
std::vector<Finding> judge_machine(const MachineFacts& facts);

}  // namespace tribus::doctor
