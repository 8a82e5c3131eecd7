#pragma once

#include <chrono>
#include <span>
#include <string>

#include "config/schema/schema.h"
#include "core/time.h"
#include "pipelines/realtime/loop.h"

namespace tribus {

/// The data thread publishes its figures several times a second even if it has nothing else to do.
/// A longer gap than this is no mere delay on a busy machine: the thread stands still.
inline constexpr Duration kFigureLife = std::chrono::seconds(1);

/// The state of all inputs and outputs in one line, also for a service manager: "servos: in
/// failsafe; receiver: wire silent (no bytes any more)". The worst state comes first. Both lists
/// are in the order of the configuration; the data thread published them at `figures_at`. Durations
/// of a failsafe or loss are rounded down to steps, so that they do not change the line all the
/// time. Thread-safe.
std::string status_line(const Configuration& configuration, std::span<const InputStatus> inputs,
                        std::span<const OutputStatus> outputs, Instant figures_at, Instant now);

}  // namespace tribus
