#pragma once

#include <string>

namespace tribus {

/// The configuration language as a JSON schema (draft 7), for editors: taplo and what stands on it
/// check and complete a file whose first line is `#:schema PATH-OF-THE-SCHEMA`. Made from the key
/// table and the registry; rules between tables are beyond it.
std::string json_schema();

}  // namespace tribus
