#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/recorder/recording_folder.h"
#include "config/build/build.h"
#include "config/schema/schema.h"
#include "core/time.h"

/// The contents of a recording, except what passed the ports.
namespace tribus {

struct RecordingPlan {
    /// In the order of the ports of the configuration.
    std::vector<RecordedPort> ports;
    std::vector<SideFile> files;
    std::string replay;
    /// For each port that is not recorded: `/dev/ttyAMA3: why`.
    std::vector<std::string> lacks;
    /// When the recording began.
    Instant begin{};
};

/// Upper limit of the text of a plan: larger than the usual configurations with the files that they
/// name.
inline constexpr std::size_t kMostPlanBytes = std::size_t{16} * 1024 * 1024;

/// The plan for `ports`, which need not be all ports of the configuration. Pure.
RecordingPlan plan_recording(const Configuration& configuration, const std::vector<PortPlan>& ports,
                             Instant begin);

/// Text for the process after a crash; without the rings. Pure.
std::string plan_to_text(const RecordingPlan& plan);
/// Nothing if the text is not a plan, or not one that `plan_recording` makes: every file name must
/// stay in the folder and be unique. Pure.
std::optional<RecordingPlan> plan_from_text(std::string_view text);

}  // namespace tribus
