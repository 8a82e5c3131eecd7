#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "app/wire/dronecan/dronecan_explainer.h"
#include "core/channel_frame.h"

/// The fields of a DroneCAN payload, by name.
namespace tribus {

struct ExplainedFields {
    /// Nested as in the type. Strings are unchanged, bytes are in hex, measurements that the sender
    /// does not know are null.
    nlohmann::ordered_json values = nlohmann::ordered_json::object();
    /// Units of the fields that have one. The key is the path without item numbers:
    /// "commands.actuator_id".
    nlohmann::ordered_json units = nlohmann::ordered_json::object();
};
/// The fields of a complete transfer of a known type; else empty.
ExplainedFields fields_of(const ExplainedTransfer& transfer);

/// The channels of a complete RCInput transfer, in microseconds, as in a decoded frame.
struct RcInputChannels {
    std::array<std::optional<std::uint16_t>, kChannelCount> channels;
    bool failsafe = false;
};
/// Nothing for any other transfer.
std::optional<RcInputChannels> rc_input_of(const ExplainedTransfer& transfer);

/// Text such as `status 1, quality 200, rcin [1500 1500] us`.
std::string fields_text(const ExplainedFields& fields);

/// JSON that any terminal and reader accepts: ASCII without control characters.
std::string plain_json(const nlohmann::ordered_json& value);

}  // namespace tribus
