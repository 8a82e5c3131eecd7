#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "core/wire_shape.h"
#include "transports/codecs/protocol.h"
#include "transports/links/medium.h"

namespace tribus {

/// All protocols of the program, one line each in the source. Reentrant.
std::span<const Protocol* const> protocols();

/// The protocol with that name, or null. Reentrant.
const Protocol* find_protocol(std::string_view name);

/// Names of the protocols whose messages [values.NAME] can read. Words of a choice are constant, so
/// they stand here once more; a test compares.
inline constexpr std::array<std::string_view, 1> kValueProtocols{"crsf-telemetry"};

/// All media of the program, one line each in the source. Reentrant.
std::span<const Medium* const> media();

/// The media that carry protocols of that shape, at least one. Reentrant.
std::vector<const Medium*> media_for(WireShape shape);

}  // namespace tribus
