#include "config/show/effective.h"

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <variant>

#include "config/keys/keys.h"
#include "config/read/rules.h"
#include "config/read/supervision.h"
#include "config/show/effective_channels.h"
#include "config/show/effective_lines.h"
#include "config/show/effective_values.h"
#include "config/show/fields_json.h"
#include "config/show/write_toml.h"

namespace tribus {
namespace {

using Json = nlohmann::ordered_json;

Json port_json(const PortConfig& port, const Protocol& protocol, std::span<const Key> own_keys) {
    Json json = Json::object();
    json["protocol"] = protocol.name;
    json[std::string(port.medium->place.key)] = port.device;
    json.update(values_json(port.settings, own_keys));
    return json;
}

/// Whether a check of the link applies to the protocol of the input.
bool is_checked(const InputConfig& input, std::string_view key) {
    if (key == "zero_guard") {
        return input.supervision.raw_zero.has_value();
    }
    return !is_about_flags(key) || has_flags(*input.protocol, input.settings);
}

Json input_json(const InputConfig& input) {
    SupervisionSettings supervision = input.supervision;
    supervision.frame_lost_run = supervision.frame_lost_run.value_or(supervision.timeout);
    const auto own_keys = protocol_keys(*input.protocol, *input.port.medium, SettingScope::input);
    Json json = port_json(input.port, *input.protocol, own_keys);
    json.update(in_order_of_rows(fields_json(supervision, input_keys()), input_keys(),
                                 [&](std::string_view key) { return is_checked(input, key); }));
    json["failsafe_when"] = Json::array();
    for (const ValueRule& rule : supervision.failsafe_when) {
        json["failsafe_when"].push_back(value_rule_json(rule));
    }
    for (const ChannelRule& rule : input.channels) {
        json["map"][std::to_string(rule.output + 1)] = channel_json(rule, {});
    }
    json.update(values_json(input.settings, own_keys));
    return json;
}

Json output_json(const OutputConfig& output) {
    const auto own_keys =
        protocol_keys(*output.protocol, *output.port.medium, SettingScope::output);
    Json json = port_json(output.port, *output.protocol, own_keys);
    json.update(fields_json(output, output_keys()));
    json.update(fields_json(output, own_keys));
    json.update(values_json(output.settings, own_keys));
    return json;
}

/// The most frequent pulse; on a tie, the centre.
Pulse commonest(const std::array<Pulse, kChannelCount>& presets) {
    std::map<Pulse, int> counts;
    for (const Pulse pulse : presets) {
        ++counts[pulse];
    }
    Pulse best = kCentrePulse;
    for (const auto& [pulse, count] : counts) {
        best = count > counts[best] ? pulse : best;
    }
    return best;
}

Json presets_json(const std::array<Pulse, kChannelCount>& presets) {
    const Pulse other = commonest(presets);
    Json json = Json::object();
    for (std::size_t i = 0; i < presets.size(); ++i) {
        if (presets[i] != other) {
            json[std::to_string(i + 1)] = number_json(presets[i].microseconds());
        }
    }
    json[std::string(kOtherChannels)] = number_json(other.microseconds());
    return json;
}

Json failsafe_json(const FailsafeSettings& failsafe) {
    Json json = fields_json(failsafe, output_failsafe_keys());
    if (failsafe.release_when) {
        json["release_when"] = value_rule_json(*failsafe.release_when);
    }
    if (failsafe.action == FailsafeAction::preset || failsafe.presets != default_presets()) {
        json["preset"] = presets_json(failsafe.presets);
    }
    return json;
}

template <class Ports>
Json names_json(const std::vector<std::size_t>& indices, const Ports& ports) {
    Json names = Json::array();
    for (const std::size_t index : indices) {
        names.push_back(ports[index].name);
    }
    return names;
}

Json pipeline_json(const PipelineConfig& pipeline, const Configuration& configuration) {
    Json json = Json::object();
    const SelectionSettings& selection = pipeline.selection;
    json["from"] = names_json(selection.inputs, configuration.inputs);
    json["to"] = names_json(pipeline.outputs, configuration.outputs);
    json.update(fields_json(selection, pipeline_keys()));
    if (selection.mode != SelectionMode::median) {
        json.erase("tolerance");
    }
    if (selection.handover) {
        const std::size_t input = selection.inputs[selection.handover->input];
        json["handover"]["input"] = configuration.inputs[input].name;
        json["handover"]["channel"] = selection.handover->channel + 1;
    }
    for (const ChannelRule& rule : pipeline.channels) {
        json["channels"][std::to_string(rule.output + 1)] = channel_json(rule, configuration.lines);
    }
    for (std::size_t i = 0; i < pipeline.outputs.size(); ++i) {
        const std::string& output = configuration.outputs[pipeline.outputs[i]].name;
        json["failsafe"]["output"][output] = failsafe_json(pipeline.failsafe[i]);
    }
    return json;
}

Json effective(const Configuration& configuration) {
    Json json = Json::object();
    json["runtime"] = fields_json(configuration.runtime, runtime_keys());
    for (const InputConfig& input : configuration.inputs) {
        json["input"][input.name] = input_json(input);
    }
    for (const OutputConfig& output : configuration.outputs) {
        json["output"][output.name] = output_json(output);
    }
    for (const PipelineConfig& pipeline : configuration.pipelines) {
        json["pipeline"][pipeline.name] = pipeline_json(pipeline, configuration);
    }
    for (const LineConfig& line : configuration.lines) {
        if (!line.of_output) {
            json["gpio"][line.name] = line_json(line, configuration);
        }
    }
    for (const SensorType& type : configuration.sensor_types) {
        json["sensor_type"][type.name] = sensor_type_json(type);
    }
    for (const ValuesConfig& values : configuration.values) {
        json["values"][values.name] = named_values_json(values);
    }
    for (const SensorBusConfig& bus : configuration.sensor_buses) {
        json["sensor_bus"][bus.name] = sensor_bus_json(bus);
    }
    for (const DroneCanConfig& node : configuration.dronecan) {
        json["dronecan"][node.name] = dronecan_json(node);
    }
    if (configuration.recorder) {
        json["recorder"] = fields_json(*configuration.recorder, recorder_keys());
    }
    return json;
}

}  // namespace

std::string effective_toml(const Configuration& configuration) {
    return write_toml(effective(configuration), root_keys());
}

std::string effective_json(const Configuration& configuration) {
    return effective(configuration).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace tribus
