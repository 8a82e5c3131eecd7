#pragma once

#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/statements.h"

namespace tribus {

/// The file without the messages and signals that have faults. Pure and reentrant.
DbcFile usable_dbc_parts(DbcStatements statements);

}  // namespace tribus
