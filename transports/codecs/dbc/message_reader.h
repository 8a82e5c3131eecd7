#pragma once

#include <vector>

#include "transports/codecs/dbc/statements.h"
#include "transports/codecs/dbc/tokens.h"

namespace tribus {

/// Reads a message behind its BO_, with its signals; checks whatever needs no other statement. The
/// message that holds the signals of no message is read but not kept. False after a mistake.
bool read_dbc_message(DbcTokens& tokens, std::vector<DbcMessageStatement>& messages);

}  // namespace tribus
