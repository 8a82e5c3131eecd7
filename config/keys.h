#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/setting.h"
#include "transports/codecs/protocol.h"

/// THE key table of the configuration language: key, type, default, range, help. Validation, the
/// reading into structs, the effective configuration and the JSON schema are all made from it.
/// The unit follows from the type: durations carry theirs, pulses are microseconds.
namespace tribus {

/// What stands behind a key.
enum class KeyKind : std::uint8_t {
    value,         ///< as `setting.type` says
    protocol,      ///< the name of a protocol in the registry
    names,         ///< a name, or a list of names
    presets,       ///< { channel number = pulse, other = pulse }
    weights,       ///< { channel number = weight }
    list,          ///< a list of tables with the keys `inside`
    table,         ///< a table with the keys `inside`
    named_tables,  ///< tables with the keys `inside`, under names that the user chooses
    texts,         ///< { name = text }, under names that the user chooses
    line,          ///< a GPIO line: its number on a chip, or its name
    channels,      ///< { channel number = channel number, or a table with the keys `inside` }
};

struct Key {
    Setting setting;
    KeyKind kind = KeyKind::value;
    std::span<const Key> inside = {};
    /// The tables inside have the keys of their protocol too, those of this scope.
    std::optional<SettingScope> protocol_scope = {};

    std::string_view name() const { return setting.key; }
};

/// The whole language: what may stand at the top of a file.
std::span<const Key> root_keys();
std::span<const Key> runtime_keys();
/// Those that every input has, whatever its protocol; the first names the protocol.
std::span<const Key> input_keys();
std::span<const Key> output_keys();
std::span<const Key> loss_rule_keys();
std::span<const Key> release_rule_keys();
std::span<const Key> handover_keys();
std::span<const Key> pipeline_keys();
std::span<const Key> channel_keys();
std::span<const Key> failsafe_keys();
/// Those that a GPIO line may have, whatever its role.
std::span<const Key> line_keys();
/// Those that a sensor bus may have, whatever its role.
std::span<const Key> sensor_bus_keys();
/// Those of one entry of its `sensor`.
std::span<const Key> sensor_keys();
std::span<const Key> sensor_type_keys();
std::span<const Key> values_keys();
std::span<const Key> dronecan_keys();
std::span<const Key> recorder_keys();
/// Those of [pipeline.NAME.failsafe.output.NAME].
std::span<const Key> output_failsafe_keys();

/// The row of that name, which must exist.
const Key& key_named(std::span<const Key> keys, std::string_view name);

/// The key that names the device or the interface.
const Key& place_key(LinkKind link);

/// The keys that an input, or an output, has because of its protocol: its place, what its kind of
/// link brings, and the protocol's own.
std::vector<Key> protocol_keys(const Protocol& protocol, SettingScope scope);

/// What a channel can be made from: each entry has exactly one of these keys.
std::span<const std::string_view> channel_source_names();
/// The channel keys that change a value on its way; a switch and a fixed pulse have none of them.
std::span<const std::string_view> shaping_key_names();

inline constexpr double kLeastPulse = 500;
inline constexpr double kMostPulse = 2500;
/// No wire carries a longer one; received values may lie outside of what a rule may send.
inline constexpr double kMostWirePulse = 4095;
/// A mix needs no more to swap and scale; keeps sums far from the ends of a pulse.
inline constexpr double kMostWeight = 10;
/// What `preset` holds where the file gives none: throttle low, the rest centred.
inline constexpr std::string_view kDefaultPreset = "{ 3 = 988, other = 1500 }";
/// The entry of `preset` for all channels that it does not name.
inline constexpr std::string_view kOtherChannels = "other";

}  // namespace tribus
