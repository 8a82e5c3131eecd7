#pragma once

#include "app/control_server.h"
#include "app/daemon.h"

namespace tribus {

/// Adds the requests `reload [TIME]`, `confirm [TRIAL]`, `back [TRIAL]` and `configuration`;
/// docs/status.md describes their answers. The daemon must outlive the server.
void add_control_requests(ControlServer& control, Daemon& daemon);

}  // namespace tribus
