#pragma once

#include "app/doctor/kernel_files.h"
#include "app/doctor/serial_facts.h"

namespace tribus::doctor {

/// Fills in who has the port open, from /proc: those of other users only as root. A login that
/// waits for the port is seen by everyone, for it says so in its arguments.
void look_at_users(const KernelFiles& files, SerialFacts& facts);

}  // namespace tribus::doctor
