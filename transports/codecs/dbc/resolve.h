#pragma once

#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/statements.h"

namespace tribus {

/// Combines the statements of a file and checks what needs several of them. Pure and reentrant.
DbcFile resolve_dbc(DbcStatements statements);

}  // namespace tribus
