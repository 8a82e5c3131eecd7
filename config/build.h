#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "config/schema.h"
#include "pipelines/engine.h"
#include "pipelines/realtime/loop.h"
#include "transports/links/link.h"

namespace tribus {

/// One device or interface to open, for all inputs and outputs that name it.
struct PortPlan {
    PortConfig config;
    PortWiring wiring;
};

/// The engine that a configuration describes. Opens nothing.
std::unique_ptr<Engine> build_engine(const Configuration& configuration);

/// The devices that it needs, each once.
std::vector<PortPlan> plan_ports(const Configuration& configuration);

/// Opens one device. The only place in the program that does. The error is for the person who set
/// it up: `file:line:column: ...`.
/// The ids that a CAN interface is to pass are those of the engine's inputs and outputs.
tl::expected<std::unique_ptr<Link>, std::string> open_port(const Configuration& configuration,
                                                           const Engine& engine,
                                                           const PortPlan& plan);

}  // namespace tribus
