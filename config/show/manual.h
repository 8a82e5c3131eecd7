#pragma once

#include <string>

namespace tribus {

/// Every key of the configuration language with its type, range, default, meaning and an example,
/// made from the key table and the registry: docs/configuration.md.
std::string manual_markdown();

/// The same as a manual page in mdoc, tribus.toml(5).
std::string manual_mdoc();

}  // namespace tribus
