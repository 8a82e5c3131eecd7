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
    /// In the order of the ports of the configuration.
    std::vector<RecordedPort> ports;
    std::vector<SideFile> files;
    std::string replay;
    /// `/dev/ttyAMA3: why`, of each port that is not recorded.
    std::vector<std::string> lacks;
    /// Since when it has been recorded.
    Instant begin{};
};

/// Of these ports, which need not be all. Pure.
RecordingPlan plan_recording(const Configuration& configuration, const std::vector<PortPlan>& ports,
                             Instant begin);

/// For the process that comes after one that crashed; without the rings themselves. Pure.
std::string plan_to_text(const RecordingPlan& plan);
/// Nothing where the text is no plan, or one that `plan_recording` does not make: every name in it
/// is of a file in the same folder, and no two are the same.
std::optional<RecordingPlan> plan_from_text(std::string_view text);

}  // namespace tribus
