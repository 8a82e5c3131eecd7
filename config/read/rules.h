#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "config/read/draft.h"
#include "config/read/table.h"

/// Reads values by channel number, and rules about channels.
namespace tribus {

/// Converts "1" to "18", without leading zero or sign, to an index from 0.
std::optional<std::size_t> channel_of(std::string_view key);
/// The channels that `channel_of` accepts, for messages.
std::string allowed_channels();

/// A rule about the value of one channel or, if `keys` has `all_zero`, of all channels. `title`
/// names it in messages, `example` is an example of one.
struct RuleRef {
    const Value& value;
    std::string title;
    std::string_view example;
    std::string_view otherwise;  ///< what a rule that every value matches would do
    std::span<const Key> keys;
};
std::optional<ValueRule> read_value_rule(const RuleRef& ref, Reading reading);
/// The keys with limits of a value.
inline constexpr std::array<std::string_view, 3> kValueLimits{"below", "above", "between"};
/// Whether at least one of these keys was given.
bool has_value_limit(const TableContent& content);

/// Channel rules of [pipeline.NAME.channels] or [input.NAME.map]. `draft` is null for an input,
/// whose channels cannot be made from lines.
struct PlacedRules {
    std::vector<ChannelRule> rules;
    std::vector<Location> where;  ///< place of each source
};
PlacedRules read_channels(const Value& value, const std::string& title, Draft* draft,
                          Reading reading);

/// Reads `preset`, complete for all channels. `nullopt` if it is not a table.
using Presets = std::array<Pulse, kChannelCount>;
std::optional<Presets> read_presets(const Value& value, Mistakes& mistakes);
/// The presets of kDefaultPreset.
Presets default_presets();

/// Adds a mistake at `upper` if no value can lie between the two limits.
void check_limits(const TableContent& content, std::string_view lower, std::string_view upper,
                  std::string_view otherwise, Mistakes& mistakes);

/// The pulse of a key. `nullopt` if it has no valid value.
std::optional<Pulse> pulse_of(const TableContent& content, std::string_view key);

}  // namespace tribus
