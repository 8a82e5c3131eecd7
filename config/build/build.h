#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "config/build/dronecan.h"
#include "config/schema/schema.h"
#include "core/number_reservation.h"
#include "core/random_seed.h"
#include "core/wall_clock.h"
#include "pipelines/engine/engine.h"
#include "pipelines/realtime/gpio_thread.h"
#include "pipelines/realtime/loop.h"
#include "pipelines/stations/stations.h"
#include "pipelines/values/value_engine.h"
#include "transports/links/link.h"
#include "transports/links/medium.h"

namespace tribus {

/// One device or interface to open, and the inputs and outputs that use it.
struct PortPlan {
    PortConfig config;
    PortWiring wiring;
    /// The output's period, on a medium with a period.
    Duration period{};
    /// Whether threads of the link ask for real-time scheduling.
    bool realtime = true;
};

/// The sources of codecs on a machine. Simulations have none of them.
struct CodecSources {
    const WallClock* clock = nullptr;
    /// Another seed at each call. Without it all seeds are zeros.
    RandomSource random = nullptr;
    /// The numbers that an epoch file keeps. Without it links with an epoch send and take nothing.
    std::function<NumberReservation*(const std::string& epoch)> numbers{};
};

/// Builds the engine of a configuration. Opens nothing. What `sources` give must outlive the codecs
/// of the engine, which a reload hands on to the next one.
std::unique_ptr<Engine> build_engine(const Configuration& configuration, MachineId machine = {},
                                     const CodecSources& sources = {});

/// Builds the value engine: named values and sensor buses. Null if nothing needs it. Outputs of
/// `engine` that send values read them from it, so it must outlive `engine`. Opens nothing.
/// `clock`, if any, must outlive it.
std::unique_ptr<ValueEngine> build_value_engine(const Configuration& configuration, Engine& engine,
                                                const WallClock* clock = nullptr);

/// The tasks of the GPIO lines, in the order of the configuration.
std::vector<LineTask> line_tasks(const Configuration& configuration);

/// The devices and interfaces of the configuration, each once.
std::vector<PortPlan> plan_ports(const Configuration& configuration);

/// Returns the needs of all users of one port.
LinkUse link_use(const Stations& stations, const PortPlan& plan);

/// Opens one device. Only this function and `open_line` open devices. Error: `file:line:column:
/// ...`.
tl::expected<std::unique_ptr<Link>, std::string> open_port(const Configuration& configuration,
                                                           const Stations& stations,
                                                           const PortPlan& plan);

/// Opens one GPIO line. An output gets its level before the first frame. Error as above.
tl::expected<std::unique_ptr<HeldLine>, std::string> open_line(const Configuration& configuration,
                                                               const LineConfig& line);

}  // namespace tribus
