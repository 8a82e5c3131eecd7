#pragma once

#include "config/language/document.h"
#include "config/language/mistakes.h"

namespace tribus {

/// Adds a mistake for each `[[header]]` of a table that is no list in the language, and turns the
/// list that it made into its first table, so that its content can be read.
void replace_header_lists(Table& root, Mistakes& mistakes);

}  // namespace tribus
