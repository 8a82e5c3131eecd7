#pragma once

#include <span>
#include <string_view>

#include "transports/codecs/protocol.h"

namespace tribus {

/// THE table: every protocol that the program speaks, one line each.
std::span<const Protocol* const> protocols();

/// The protocol of that name, or null.
const Protocol* find_protocol(std::string_view name);

}  // namespace tribus
