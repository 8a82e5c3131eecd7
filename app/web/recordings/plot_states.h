#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "app/replay/simulate_inputs.h"
#include "app/web/recordings/plot_recording.h"
#include "config/schema/schema.h"

namespace tribus::web {

/// Runs the configuration over the recordings in `files`, by the index of their source, and sets
/// `states` of the plot up to the end of its span. Returns why it stopped before.
std::optional<std::string> simulate_states(const Configuration& configuration,
                                           std::span<const SimulatedSource> sources,
                                           const std::map<std::size_t, std::string>& files,
                                           RecordingPlot& plot);

}  // namespace tribus::web
