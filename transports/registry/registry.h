#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "transports/codecs/protocol.h"
#include "transports/links/medium.h"

namespace tribus {

/// All protocols of the program, one line each in the source. Reentrant.
std::span<const Protocol* const> protocols();

/// The protocol with that name, or null. Reentrant.
const Protocol* find_protocol(std::string_view name);

/// Names of the protocols whose messages [values.NAME] can read. Words of a choice are constant, so
/// they stand here once more; a test compares.
inline constexpr std::array<std::string_view, 2> kValueProtocols{"crsf-telemetry",
                                                                 "mavlink-telemetry"};

/// All media of the program, one line each in the source. Reentrant.
std::span<const Medium* const> media();

/// Whether inputs and outputs of the protocol can use the medium. Reentrant.
bool carries(const Medium& medium, const Protocol& protocol);
/// The media that carry the protocol, at least one; the usual one first. Reentrant.
std::vector<const Medium*> media_for(const Protocol& protocol);

}  // namespace tribus
