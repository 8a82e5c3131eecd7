#pragma once

#include <string>

namespace tribus {

/// JSON schema (draft 7) of the configuration language, for editors. Editors with taplo check and
/// complete a file whose first line is `#:schema PATH-OF-THE-SCHEMA`. Generated from the key table
/// and the registry. It does not contain the checks across tables.
std::string json_schema();

}  // namespace tribus
