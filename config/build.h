#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "config/build_dronecan.h"
#include "config/schema.h"
#include "pipelines/engine.h"
#include "pipelines/realtime/gpio_thread.h"
#include "pipelines/realtime/loop.h"
#include "pipelines/value_engine.h"
#include "transports/links/can_socket.h"
#include "transports/links/link.h"

namespace tribus {

/// One device or interface to open, for all inputs and outputs that name it.
struct PortPlan {
    PortConfig config;
    PortWiring wiring;
};

/// The engine that a configuration describes. Opens nothing.
std::unique_ptr<Engine> build_engine(const Configuration& configuration, MachineId machine = {});

/// Its named values and sensor buses; null where nothing needs them. Outputs of `engine` that send
/// values take them from there from now on, so it must outlive the engine. Opens nothing.
std::unique_ptr<ValueEngine> build_value_engine(const Configuration& configuration, Engine& engine);

/// What its GPIO lines are for, in their order.
std::vector<LineTask> line_tasks(const Configuration& configuration);

/// The devices that it needs, each once.
std::vector<PortPlan> plan_ports(const Configuration& configuration);

/// What the users of one CAN interface need of it.
CanSocketSettings can_socket_settings(const Engine& engine, const ValueEngine* values,
                                      const PortPlan& plan);

/// Nothing has the name of that device or interface (yet).
bool is_missing(const PortConfig& port);

/// Opens one device. With `open_line` the only place in the program that does. The error is for the
/// person who set it up: `file:line:column: ...`. The ids that a CAN interface is to pass are those
/// of the engine's inputs and outputs, and of the values.
tl::expected<std::unique_ptr<Link>, std::string> open_port(const Configuration& configuration,
                                                           const Engine& engine,
                                                           const ValueEngine* values,
                                                           const PortPlan& plan);

/// Opens one GPIO line, an output at the level that it has before the first frame. Errors as above.
tl::expected<std::unique_ptr<HeldLine>, std::string> open_line(const Configuration& configuration,
                                                               const LineConfig& line);

}  // namespace tribus
