#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/recording_plan.h"
#include "app/ring_memory.h"
#include "core/time.h"
#include "pipelines/realtime/capture_ring.h"

namespace tribus {

/// What a process had in memory when it ended otherwise than by itself.
struct LeftRecording {
    RecordingPlan plan;
    std::vector<RingMemory> memories;
    /// One for each port of the plan. Their pieces may be anything.
    std::vector<CaptureRing> rings;
    Instant latest{};  ///< when the newest of all was recorded
};

/// The plan's file in such a folder.
inline constexpr const char* kRecordingPlanFile = "plan.json";

/// Reads it. Nothing in the folder is believed: not what kinds of files there are, not their sizes,
/// and not what they hold. The error is a sentence.
tl::expected<LeftRecording, std::string> read_left_recording(const std::filesystem::path& folder,
                                                             Instant now);

}  // namespace tribus
