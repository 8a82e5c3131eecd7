#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "config/keys/field.h"
#include "core/setting.h"
#include "transports/codecs/protocol.h"
#include "transports/links/medium.h"

/// THE key table of the configuration language: key, type, default, range, help. The checks, the
/// reader, the effective configuration and the JSON schema are made from it. The type determines
/// the unit: durations have a unit in the text, pulses are in microseconds.
namespace tribus {

/// What the value of a key is.
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

/// A row of the key table.
struct Key {
    Setting setting;
    KeyKind kind = KeyKind::value;
    std::span<const Key> inside = {};
    /// If set, the tables inside also have the keys of their protocol with this scope.
    std::optional<SettingScope> protocol_scope = {};
    /// The member that the value sets. Its initial value is the default of the key, unless the row
    /// says something else.
    Field field = {};

    std::string_view name() const { return setting.key; }
};

/// The default of the key: `fallback` of the row, or else the initial value of its member. Absent
/// if the key is required, or if the row says in words what holds without it.
std::optional<SettingValue> default_of(const Key& key);

/// The keys at the top of a file.
std::span<const Key> root_keys();
std::span<const Key> runtime_keys();
/// Keys of every input, whatever its protocol. The first one is the protocol.
std::span<const Key> input_keys();
std::span<const Key> output_keys();
std::span<const Key> loss_rule_keys();
std::span<const Key> release_rule_keys();
std::span<const Key> handover_keys();
std::span<const Key> pipeline_keys();
std::span<const Key> channel_keys();
std::span<const Key> failsafe_keys();
/// Keys of a GPIO line of any role.
std::span<const Key> line_keys();
/// Keys of a sensor bus of any role.
std::span<const Key> sensor_bus_keys();
/// Keys of one entry of `sensor` in a sensor bus.
std::span<const Key> sensor_keys();
std::span<const Key> sensor_type_keys();
std::span<const Key> values_keys();
std::span<const Key> dronecan_keys();
std::span<const Key> recorder_keys();
/// Keys of [pipeline.NAME.failsafe.output.NAME].
std::span<const Key> output_failsafe_keys();

/// The row with that name, which must exist.
const Key& key_named(std::span<const Key> keys, std::string_view name);

/// The key that names the place on a medium, such as `device`.
Key place_key(const Medium& medium);

/// The keys that an input or output has because of its protocol and medium. The place is the first.
std::vector<Key> protocol_keys(const Protocol& protocol, const Medium& medium, SettingScope scope);
/// The same for all media that carry the protocol, each key once. If there are several media, none
/// of their places is required.
std::vector<Key> protocol_keys(const Protocol& protocol, SettingScope scope);

/// Names of all protocols in the registry.
std::vector<std::string_view> protocol_names();
/// Names of the protocols that an input or an output can have.
std::vector<std::string_view> protocol_names(SettingScope way);

/// The sources of a channel. Each entry has exactly one of these keys.
std::span<const std::string_view> channel_source_names();
/// The keys of a channel that change its value. A switch and a fixed pulse must not have them.
std::span<const std::string_view> shaping_key_names();

inline constexpr double kLeastPulse = 500;
inline constexpr double kMostPulse = 2500;
/// Upper limit of a pulse on any wire. Received values may exceed what a rule may send.
inline constexpr double kMostWirePulse = 4095;
/// Upper limit of the raw values of a scale, which have 11 bits.
inline constexpr double kMostRaw = 2047;
/// Upper limit of a weight in a mix. It suffices to swap and scale, and keeps sums within a Pulse.
inline constexpr double kMostWeight = 10;
/// Default of `preset`: throttle low, all others centred.
inline constexpr std::string_view kDefaultPreset = "{ 3 = 988, other = 1500 }";
/// Key in `preset` for all channels that it does not name.
inline constexpr std::string_view kOtherChannels = "other";

}  // namespace tribus
