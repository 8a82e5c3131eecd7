#pragma once

#include <string>
#include <vector>

#include "config/show/manual_sections.h"

namespace tribus {

/// Every key of the configuration language with its type, range, default, meaning and an example,
/// made from the key table and the registry: docs/configuration.md.
std::string manual_markdown(const std::vector<ManualSection>& sections = manual_sections());

/// The same as a manual page in mdoc, tribus.toml(5).
std::string manual_mdoc(const std::vector<ManualSection>& sections = manual_sections());

}  // namespace tribus
