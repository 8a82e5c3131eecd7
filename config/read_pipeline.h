#pragma once

#include "config/draft.h"
#include "config/read_table.h"

namespace tribus {

/// One [pipeline.NAME]. The inputs and outputs of the draft must be complete; marks those that it
/// uses.
PipelineConfig read_pipeline(const Entry& entry, const Table& table, Draft& draft, Reading reading);

}  // namespace tribus
