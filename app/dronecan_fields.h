#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "app/dronecan_explainer.h"
#include "core/channel_frame.h"

/// The fields of a DroneCAN payload by their names.
namespace tribus {

struct ExplainedFields {
    /// As its type nests them; texts as they are, bytes in hex, measurements that the sender does
    /// not know null.
    nlohmann::ordered_json values = nlohmann::ordered_json::object();
    /// Of those that have one, by path without the numbers of items: "commands.actuator_id".
    nlohmann::ordered_json units = nlohmann::ordered_json::object();
};
/// Of a whole transfer of a known type; else empty.
ExplainedFields fields_of(const ExplainedTransfer& transfer);

/// Of a whole RCInput transfer, the channels that a decoded frame has, in microseconds.
struct RcInputChannels {
    std::array<std::optional<std::uint16_t>, kChannelCount> channels;
    bool failsafe = false;
};
std::optional<RcInputChannels> rc_input_of(const ExplainedTransfer& transfer);

/// `status 1, quality 200, rcin [1500 1500] us`
std::string fields_text(const ExplainedFields& fields);

/// JSON that any terminal and reader takes: ASCII, without control characters.
std::string plain_json(const nlohmann::ordered_json& value);

}  // namespace tribus
