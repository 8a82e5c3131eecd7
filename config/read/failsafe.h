#pragma once

#include <vector>

#include "config/read/draft.h"
#include "config/read/table.h"

namespace tribus {

/// Reads [pipeline.NAME.failsafe] for each output of the pipeline: the key in the output's own
/// table, or that of the pipeline, or the default of its protocol. `entry` is null if there is no
/// such table.
std::vector<FailsafeSettings> read_failsafe(const Entry* entry, const PipelineConfig& pipeline,
                                            const Draft& draft, Reading reading);

}  // namespace tribus
