#pragma once

#include <span>
#include <string_view>

#include "transports/codecs/protocol.h"

namespace tribus {

/// All protocols of the program, one line each in the source. Reentrant.
std::span<const Protocol* const> protocols();

/// The protocol with that name, or null. Reentrant.
const Protocol* find_protocol(std::string_view name);

}  // namespace tribus
