#pragma once

#include "config/draft.h"
#include "config/read_table.h"

namespace tribus {

/// One [input.NAME] or [output.NAME]. All that can be read is, whatever else is wrong in it.
InputDraft read_input(const Entry& entry, const Table& table, Reading reading);
OutputDraft read_output(const Entry& entry, const Table& table, Reading reading);

}  // namespace tribus
