#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "config/keys.h"
#include "config/schema.h"
#include "pipelines/settings.h"

/// Parts of the effective configuration as JSON that reads as the file would.
namespace tribus {

/// Whole numbers without a point.
nlohmann::ordered_json number_json(double number);

/// A value as its type is written.
nlohmann::ordered_json value_json(SettingType type, const SettingValue& value);

/// The values that `keys` name, in their order and as their types are written.
nlohmann::ordered_json values_json(const SettingValues& values, std::span<const Key> keys);

nlohmann::ordered_json value_rule_json(const ValueRule& rule);

/// A number for a channel that passes as it is, else a table with everything.
nlohmann::ordered_json channel_json(const ChannelRule& rule, std::span<const LineConfig> lines);

}  // namespace tribus
