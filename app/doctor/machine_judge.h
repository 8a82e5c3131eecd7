#pragma once

#include <vector>

#include "app/doctor/finding.h"
#include "app/doctor/machine_facts.h"

namespace tribus::doctor {

/// What of the machine makes RC on it worse. Pure.
std::vector<Finding> judge_machine(const MachineFacts& facts);

}  // namespace tribus::doctor
