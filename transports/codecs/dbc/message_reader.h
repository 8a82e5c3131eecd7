#pragma once

#include "transports/codecs/dbc/statements.h"
#include "transports/codecs/dbc/tokens.h"

namespace tribus {

/// Reads a message and its signals after BO_. Checks everything that needs no other statement. Does
/// not keep the message for signals that belong to no message. After a mistake it goes on behind
/// the message, if the text does; else it returns false.
bool read_dbc_message(DbcTokens& tokens, DbcStatements& statements);

}  // namespace tribus
