#pragma once

#include <string_view>

#include "config/draft.h"
#include "config/read_table.h"

namespace tribus {

/// Reads how a pipeline selects its input. `selection` already has the indices of the inputs.
void read_selection(const TableContent& content, std::string_view title,
                    SelectionSettings& selection, const Draft& draft, Reading reading);

}  // namespace tribus
