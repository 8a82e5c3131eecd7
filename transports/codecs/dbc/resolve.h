#pragma once

#include <tl/expected.hpp>

#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/statements.h"

namespace tribus {

/// Puts the statements of a file together and checks what takes several of them.
tl::expected<DbcFile, DbcMistake> resolve_dbc(DbcStatements statements);

}  // namespace tribus
