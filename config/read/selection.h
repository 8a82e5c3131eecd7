#pragma once

#include <string_view>

#include "config/read/draft.h"
#include "config/read/table.h"

namespace tribus {

/// Reads how a pipeline selects its input. `selection` already has the indices of the inputs.
void read_selection(const TableContent& content, std::string_view title,
                    SelectionSettings& selection, const Draft& draft, Reading reading);

}  // namespace tribus
