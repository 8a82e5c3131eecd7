#pragma once

#include "config/read/draft.h"
#include "config/read/table.h"

namespace tribus {

/// Reads one [pipeline.NAME]. The draft must have all inputs and outputs; marks those that it uses.
PipelineConfig read_pipeline(const Entry& entry, const Table& table, Draft& draft, Reading reading);

}  // namespace tribus
