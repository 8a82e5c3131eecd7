#pragma once

#include <array>
#include <vector>

#include <tl/expected.hpp>

#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/statements.h"

namespace tribus {

/// A message's own attribute values, by DbcAttribute; nullptr where it has none.
using DbcMessageAttributes = std::array<const DbcAttributeValue*, kDbcAttributes>;

/// Applies a message's attributes, or the defaults of all messages: kind of frame, bit rate switch,
/// cycle time and data id. Checks the length, whose limits depend on the kind of frame. Pure and
/// reentrant.
tl::expected<void, DbcMistake> apply_dbc_attributes(
    const std::vector<DbcAttributeDefinition>& definitions, const DbcMessageAttributes& own,
    DbcPlace length_place, DbcMessage& message);

}  // namespace tribus
