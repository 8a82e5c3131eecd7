#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/recorder/recording_plan.h"
#include "app/recorder/ring_memory.h"
#include "core/time.h"
#include "pipelines/realtime/capture_ring.h"

namespace tribus {

/// What a crashed process had in memory.
struct LeftRecording {
    RecordingPlan plan;
    std::vector<RingMemory> memories;
    /// One for each port of the plan. Their pieces may be damaged.
    std::vector<CaptureRing> rings;
    Instant latest{};  ///< instant of the newest piece
};

/// File of the plan in that folder.
inline constexpr const char* kRecordingPlanFile = "plan.json";

/// Reads the data of a crashed process. Trusts nothing in the folder: neither the kinds of files
/// nor their sizes or contents. The error is a sentence.
tl::expected<LeftRecording, std::string> read_left_recording(const std::filesystem::path& folder,
                                                             Instant now);

}  // namespace tribus
