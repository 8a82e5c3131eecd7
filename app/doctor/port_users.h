#pragma once

#include "app/doctor/kernel_files.h"
#include "app/doctor/serial_facts.h"

namespace tribus::doctor {

/// Fills in which processes have the port open, from /proc; those of other users are visible only
/// to root. A login on the port is visible to everybody, through its arguments.
void look_at_users(const KernelFiles& files, SerialFacts& facts);

}  // namespace tribus::doctor
