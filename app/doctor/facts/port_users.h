#pragma once

#include <string>
#include <vector>

#include "app/doctor/facts/kernel_files.h"
#include "app/doctor/facts/serial_facts.h"

namespace tribus::doctor {

struct NodeUsers {
    std::vector<PortUser> users{};
    /// There are processes of other users whose open files cannot be read.
    bool hidden = false;
};

/// Which processes have the node open, or wait with a login for the port of that name.
NodeUsers users_of(const KernelFiles& files, const std::string& node,
                   const std::string& login_name = {});

/// "tribus (process 812)", some of them.
std::string names_of_users(const std::vector<PortUser>& users);

/// Fills in which processes have the port open, from /proc; those of other users are visible only
/// to root. A login on the port is visible to everybody, through its arguments.
void look_at_users(const KernelFiles& files, SerialFacts& facts);

}  // namespace tribus::doctor
