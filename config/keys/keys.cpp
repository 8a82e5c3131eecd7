#include "config/keys/keys.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "config/keys/rows_channels.h"
#include "config/keys/rows_dronecan.h"
#include "config/keys/rows_lines.h"
#include "config/keys/rows_pipelines.h"
#include "config/keys/rows_ports.h"
#include "config/keys/rows_recorder.h"
#include "config/keys/rows_values.h"
#include "config/schema/notation.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

using namespace key_rows;

constexpr std::array kRuntimeKeys{
    row<&RuntimeConfig::realtime>(
        {.key = "realtime",
         .help = "Real time for the data thread: SCHED_FIFO, locked memory, processors that do "
                 "not sleep deeply. `auto`: as far as it is permitted; `require`: all of it, or "
                 "the program does not start; `off`: none of it",
         .example = "\"require\""}),
    row<&RuntimeConfig::priority>({.key = "priority",
                                   .least = 1,
                                   .most = 99,
                                   .help = "SCHED_FIFO priority of the data thread",
                                   .example = "60"}),
    row<&RuntimeConfig::cpu>({.key = "cpu",
                              .absent = "any processor",
                              .least = 0,
                              .most = 255,
                              .help = "Processor that the data thread is pinned to",
                              .example = "3"}),
    row<&RuntimeConfig::spin>(
        {.key = "spin",
         .least = 0,
         .most = 0.0002,
         .help = "The data thread wakes up this long before a deadline and stays awake for it: "
                 "less jitter with `schedule = \"grid\"`, for that much processor time a frame; "
                 "60us is plenty",
         .example = "\"60us\""}),
};

constexpr std::array kRootKeys{
    Key{structure("runtime", "How the data thread runs"), KeyKind::table, kRuntimeKeys},
    Key{structure("input", "Where RC channels come from"), KeyKind::named_tables, kInputKeys,
        SettingScope::input},
    Key{structure("output", "Where RC channels go to"), KeyKind::named_tables, kOutputKeys,
        SettingScope::output},
    Key{structure("pipeline", "Which inputs feed which outputs, and how"), KeyKind::named_tables,
        kPipelineKeys},
    Key{structure("gpio", "GPIO lines that show a state, or control something"),
        KeyKind::named_tables, kLineKeys},
    Key{structure("sensor_bus", "i.Bus sensor buses, in either role"), KeyKind::named_tables,
        kSensorBusKeys},
    Key{structure("sensor_type", "Sensor types of your own"), KeyKind::named_tables,
        kSensorTypeKeys},
    Key{structure("values", "Named values: constants, and numbers from CAN messages"),
        KeyKind::named_tables, kValuesKeys},
    Key{structure("dronecan", "This program as a DroneCAN node"), KeyKind::named_tables,
        kDroneCanKeys},
    Key{structure("recorder",
                  "The flight recorder: keeps what passed the ports in memory, and writes it to a "
                  "folder at a failsafe, after a crash or on request"),
        KeyKind::table, kRecorderKeys},
};

}  // namespace

std::span<const Key> root_keys() {
    return kRootKeys;
}
std::span<const Key> runtime_keys() {
    return kRuntimeKeys;
}
std::span<const Key> input_keys() {
    return kInputKeys;
}
std::span<const Key> output_keys() {
    return kOutputKeys;
}
std::span<const Key> loss_rule_keys() {
    return kLossRuleKeys;
}
std::span<const Key> release_rule_keys() {
    return kReleaseRuleKeys;
}
std::span<const Key> handover_keys() {
    return kHandoverKeys;
}
std::span<const Key> pipeline_keys() {
    return kPipelineKeys;
}
std::span<const Key> channel_keys() {
    return kChannelKeys;
}
std::span<const Key> failsafe_keys() {
    return kFailsafeKeys;
}
std::span<const Key> line_keys() {
    return kLineKeys;
}
std::span<const Key> sensor_bus_keys() {
    return kSensorBusKeys;
}
std::span<const Key> sensor_keys() {
    return kSensorKeys;
}
std::span<const Key> sensor_type_keys() {
    return kSensorTypeKeys;
}
std::span<const Key> values_keys() {
    return kValuesKeys;
}
std::span<const Key> dronecan_keys() {
    return kDroneCanKeys;
}
std::span<const Key> recorder_keys() {
    return kRecorderKeys;
}
std::span<const Key> output_failsafe_keys() {
    return kOutputFailsafeKeys;
}

std::optional<SettingValue> default_of(const Key& key) {
    const Setting& setting = key.setting;
    if (!setting.fallback.empty()) {
        return default_of(setting);
    }
    const bool in_words = setting.required || !setting.absent.empty();
    return in_words || key.field.initial == nullptr ? std::nullopt : key.field.initial();
}

const Key& key_named(std::span<const Key> keys, std::string_view name) {
    const auto key = std::find_if(keys.begin(), keys.end(),
                                  [name](const Key& row) { return row.name() == name; });
    assert(key != keys.end());
    return *key;
}

Key place_key(const Medium& medium) {
    return row<&PortConfig::device>(medium.place);
}

namespace {

void append_settings(std::span<const Setting> settings, SettingScope scope, bool on_line,
                     std::vector<Key>& keys) {
    for (const Setting& setting : settings) {
        if ((setting.scope == SettingScope::both || setting.scope == scope) &&
            (on_line || !setting.of_line)) {
            keys.push_back({setting});
        }
    }
}

void append_own_keys(const Protocol& protocol, SettingScope scope, bool on_line,
                     std::vector<Key>& keys) {
    if (protocol.shape == WireShape::can_frames && scope == SettingScope::output) {
        keys.push_back(kForeignSenderKey);
    }
    append_settings(protocol.settings, scope, on_line, keys);
}

}  // namespace

std::vector<Key> protocol_keys(const Protocol& protocol, const Medium& medium, SettingScope scope) {
    std::vector<Key> keys{place_key(medium)};
    append_settings(medium.settings, scope, medium.has_line, keys);
    append_own_keys(protocol, scope, medium.has_line, keys);
    return keys;
}

std::vector<Key> protocol_keys(const Protocol& protocol, SettingScope scope) {
    const std::vector<const Medium*> media = media_for(protocol);
    std::vector<Key> keys;
    for (const Medium* medium : media) {
        keys.push_back(place_key(*medium));
        keys.back().setting.required = media.size() == 1;
    }
    for (const Medium* medium : media) {
        append_settings(medium->settings, scope, true, keys);
    }
    append_own_keys(protocol, scope, true, keys);
    return keys;
}

std::vector<std::string_view> protocol_names(SettingScope way) {
    std::vector<std::string_view> names;
    for (const Protocol* protocol : protocols()) {
        if (protocol->goes(way)) {
            names.push_back(protocol->name);
        }
    }
    return names;
}

std::vector<std::string_view> protocol_names() {
    std::vector<std::string_view> names;
    for (const Protocol* protocol : protocols()) {
        names.push_back(protocol->name);
    }
    return names;
}

std::span<const std::string_view> channel_source_names() {
    return kChannelSources;
}

std::span<const std::string_view> shaping_key_names() {
    return kShapingKeys;
}

}  // namespace tribus
