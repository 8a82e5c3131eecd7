#pragma once

#include <string_view>

#include "config/draft.h"
#include "config/read_table.h"

namespace tribus {

/// How a pipeline chooses among its inputs, whose indices `selection` has already.
void read_selection(const TableContent& content, std::string_view title,
                    SelectionSettings& selection, const Draft& draft, Reading reading);

}  // namespace tribus
