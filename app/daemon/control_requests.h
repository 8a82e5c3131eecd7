#pragma once

#include "app/daemon/control_server.h"
#include "app/daemon/daemon.h"

namespace tribus {

/// Adds the requests `reload [TIME]`, `confirm [TRIAL]`, `back [TRIAL]`, `draft` and
/// `configuration`; docs/status.md describes their answers. The daemon must outlive the server.
void add_control_requests(ControlServer& control, Daemon& daemon);
/// Adds `configuration`, which changes nothing.
void add_telling_requests(ControlServer& server, Daemon& daemon);

}  // namespace tribus
