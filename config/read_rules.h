#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "config/read_table.h"

/// Values that are written by channel number, and rules about channels.
namespace tribus {

/// "1" to "18" as an index from 0, without a leading zero or sign.
std::optional<std::size_t> channel_of(std::string_view key);
/// What `channel_of` takes, for messages.
std::string allowed_channels();

/// `failsafe_when`.
std::vector<LossRule> read_loss_rules(const Value& value, Reading reading);

/// [pipeline.NAME.channels]
std::vector<ChannelRule> read_channels(const Value& value, const std::string& title,
                                       Reading reading);

/// `preset`: complete for all channels; nothing if it is not a table.
using Presets = std::array<Pulse, kChannelCount>;
std::optional<Presets> read_presets(const Value& value, Mistakes& mistakes);
Presets default_presets();

/// With both limits, a value must be able to lie between them. Adds a mistake at `upper` if not.
void check_limits(const TableContent& content, std::string_view lower, std::string_view upper,
                  std::string_view otherwise, Mistakes& mistakes);

std::optional<Pulse> pulse_of(const TableContent& content, std::string_view key);

}  // namespace tribus
