#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/recording_folder.h"
#include "config/build.h"
#include "config/schema.h"
#include "core/time.h"

/// What a recording of a configuration consists of, beside what passed its ports.
namespace tribus {

struct RecordingPlan {
    /// In the order of the ports of the configuration; without their rings.
    std::vector<RecordedPort> ports;
    std::vector<SideFile> files;
    std::string replay;
    /// Since when it has been recorded.
    Instant begin{};
};

/// Pure.
RecordingPlan plan_recording(const Configuration& configuration, const std::vector<PortPlan>& ports,
                             Instant begin);

/// For the process that comes after one that crashed. Pure.
std::string plan_to_text(const RecordingPlan& plan);
std::optional<RecordingPlan> plan_from_text(std::string_view text);

}  // namespace tribus
