#pragma once

#include <string>

#include "app/status.h"

/// What the control socket and `tribus monitor --format json` tell: one object, in one line. Pure.
namespace tribus {

/// Raised when a field changes its meaning or goes; new ones may come at any time.
inline constexpr int kStatusVersion = 1;

/// Without a line end. Each field stands in docs/status.md.
std::string status_json(const StatusReport& report);

}  // namespace tribus
