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

/// One device to open, for an input, an output or both.
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
tl::expected<std::unique_ptr<Link>, std::string> open_port(const Configuration& configuration,
                                                           const PortPlan& plan);

}  // namespace tribus
