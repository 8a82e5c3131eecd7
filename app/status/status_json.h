#pragma once

#include <string>

#include "app/status/status.h"
#include "pipelines/engine/health_watch.h"

/// What the control socket and `tribus monitor --format json` send: one object on one line. Pure.
namespace tribus {

/// Raised when a field changes its meaning or is removed; new fields may come at any time.
inline constexpr int kStatusVersion = 1;

/// Without a line end. docs/status.md describes each field.
std::string status_json(const StatusReport& report);

/// The member of `machine` in a status that has this fact, such as "supply_V".
std::string machine_key(const FactName& fact);

/// `{"type":"metrics","text":...}` with the text of `metrics_text`, without a line end.
std::string metrics_json(const StatusReport& report);

}  // namespace tribus
