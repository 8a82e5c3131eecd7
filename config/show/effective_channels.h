#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "config/schema/schema.h"
#include "pipelines/rules/settings.h"

/// Channels in the effective configuration, as JSON.
namespace tribus {

/// A rule about channel values, as it is written in the file.
nlohmann::ordered_json value_rule_json(const ValueRule& rule);

/// The channel number if the channel is only mapped, else a table with all keys.
nlohmann::ordered_json channel_json(const ChannelRule& rule, std::span<const LineConfig> lines);

}  // namespace tribus
