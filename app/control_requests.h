#pragma once

#include "app/control_server.h"
#include "app/daemon.h"

namespace tribus {

/// What a daemon does for those who ask over its control socket, beside telling its status:
/// `reload [PERIOD]`, `confirm [TRIAL]`, `back [TRIAL]`, `configuration`; docs/status.md has
/// their answers. The daemon must outlive the server.
void add_control_requests(ControlServer& control, Daemon& daemon);

}  // namespace tribus
