#pragma once

#include "config/read/draft.h"
#include "config/read/table.h"

namespace tribus {

/// Read one [input.NAME] or [output.NAME]. They read as much as possible in spite of mistakes.
InputDraft read_input(const Entry& entry, const Table& table, Reading reading);
OutputDraft read_output(const Entry& entry, const Table& table, Reading reading);

}  // namespace tribus
