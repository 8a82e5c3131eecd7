#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "config/draft.h"
#include "config/read_table.h"

/// Values that are written by channel number, and rules about channels.
namespace tribus {

/// "1" to "18" as an index from 0, without a leading zero or sign.
std::optional<std::size_t> channel_of(std::string_view key);
/// What `channel_of` takes, for messages.
std::string allowed_channels();

/// A rule about the value of one channel, or, where that is among `keys`, about all of them.
/// `title` names it in messages, `example` shows one.
struct RuleRef {
    const Value& value;
    std::string title;
    std::string_view example;
    std::string_view otherwise;  ///< what it would mean that every value matches
    std::span<const Key> keys;
};
std::optional<ValueRule> read_value_rule(const RuleRef& ref, Reading reading);
/// The rule that the keys of a table make.
ValueRule value_rule_of(const TableContent& content);
/// The keys that limit a value.
inline constexpr std::array<std::string_view, 3> kValueLimits{"below", "above", "between"};
bool has_value_limit(const TableContent& content);

/// [pipeline.NAME.channels] or [input.NAME.map]. Channels of a pipeline may be made from the lines
/// of its draft; an input has none.
struct PlacedRules {
    std::vector<ChannelRule> rules;
    std::vector<Location> where;  ///< of what each is made from
};
PlacedRules read_channels(const Value& value, const std::string& title, Draft* draft,
                          Reading reading);

/// `preset`: complete for all channels; nothing if it is not a table.
using Presets = std::array<Pulse, kChannelCount>;
std::optional<Presets> read_presets(const Value& value, Mistakes& mistakes);
Presets default_presets();

/// With both limits, a value must be able to lie between them. Adds a mistake at `upper` if not.
void check_limits(const TableContent& content, std::string_view lower, std::string_view upper,
                  std::string_view otherwise, Mistakes& mistakes);

std::optional<Pulse> pulse_of(const TableContent& content, std::string_view key);
std::optional<PulseRange> pulses_of(const TableContent& content, std::string_view key);

}  // namespace tribus
