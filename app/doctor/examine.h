#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "app/doctor/facts/finding.h"
#include "app/doctor/facts/kernel_files.h"
#include "app/doctor/report.h"
#include "core/time.h"

namespace tribus::doctor {

/// Returns whether none of the findings about a port prevents its use now.
bool may_be_used(const std::vector<Finding>& findings);

/// The finding that an interface is unknown. `error`: that of `query_can_interface`.
Finding unknown_interface(const std::string& name, std::string_view error);

/// Looks at the port `device`. If no finding prevents its use, opens it with the settings of each
/// protocol and listens for `time` in total, as `visit_port` does. Never writes. Passes progress
/// messages to `says`.
ExaminedPort examine_port(const KernelFiles& files, const std::string& device, Duration time,
                          const std::function<void(std::string_view)>& says);

}  // namespace tribus::doctor
