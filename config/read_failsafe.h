#pragma once

#include <vector>

#include "config/draft.h"
#include "config/read_table.h"

namespace tribus {

/// [pipeline.NAME.failsafe] for each of the pipeline's outputs: what its own table says, else what
/// the pipeline's says, else the default of its protocol. `entry` is null where the file has none.
std::vector<FailsafeSettings> read_failsafe(const Entry* entry, const PipelineConfig& pipeline,
                                            const Draft& draft, Reading reading);

}  // namespace tribus
