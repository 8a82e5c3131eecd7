#pragma once

#include <vector>

#include "transports/codecs/dbc/statements.h"
#include "transports/codecs/dbc/tokens.h"

namespace tribus {

/// Reads a message and its signals after BO_. Checks everything that needs no other statement. Does
/// not keep the message for signals that belong to no message. Returns false after an error.
bool read_dbc_message(DbcTokens& tokens, std::vector<DbcMessageStatement>& messages);

}  // namespace tribus
