#include "config/show/effective.h"

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <variant>

#include "config/keys/keys.h"
#include "config/keys/rows_pipelines.h"
#include "config/read/rules.h"
#include "config/read/supervision.h"
#include "config/schema/notation.h"
#include "config/show/effective_channels.h"
#include "config/show/effective_lines.h"
#include "config/show/effective_values.h"
#include "config/show/write_toml.h"

namespace tribus {
namespace {

using Json = nlohmann::ordered_json;

SettingValues runtime_values(const RuntimeConfig& runtime) {
    SettingValues values;
    const std::string realtime = runtime.realtime == Realtime::off       ? "off"
                                 : runtime.realtime == Realtime::require ? "require"
                                                                         : "auto";
    values.set("realtime", realtime);
    values.set("priority", std::int64_t{runtime.priority});
    if (runtime.cpu) {
        values.set("cpu", std::int64_t{*runtime.cpu});
    }
    values.set("spin", runtime.spin);
    return values;
}

Json recorder_json(const RecorderConfig& recorder) {
    SettingValues values;
    if (!recorder.directory.empty()) {
        values.set("directory", recorder.directory);
    }
    values.set("memory", std::int64_t{recorder.memory_kib});
    values.set("before", recorder.before);
    values.set("after", recorder.after);
    values.set("on_failsafe", recorder.on_failsafe);
    values.set("pause", recorder.pause);
    values.set("keep", std::int64_t{recorder.keep});
    values.set("space", std::int64_t{recorder.space_mib});
    return values_json(values, recorder_keys());
}

Json port_json(const PortConfig& port, const Protocol& protocol) {
    Json json = Json::object();
    json["protocol"] = protocol.name;
    json[std::string(place_key(port.link).name())] = port.device;
    return json;
}

Json supervision_json(const InputConfig& input) {
    const SupervisionSettings& supervision = input.supervision;
    SettingValues values;
    values.set("timeout", supervision.timeout);
    if (has_flags(*input.protocol, input.settings)) {
        values.set("failsafe_flag", supervision.failsafe_flag);
        values.set("frame_lost_flag", supervision.frame_lost_flag);
        values.set("frame_lost_run", supervision.frame_lost_run.value_or(supervision.timeout));
        values.set("frame_lost_ratio", supervision.frame_lost_ratio);
    }
    values.set("frozen", supervision.frozen);
    if (supervision.plausible) {
        values.set("plausible", NumberRange{supervision.plausible->low.microseconds(),
                                            supervision.plausible->high.microseconds()});
    }
    if (supervision.raw_zero) {
        values.set("zero_guard", supervision.zero_guard);
    }
    Json json = values_json(values, input_keys());
    Json rules = Json::array();
    for (const ValueRule& rule : supervision.failsafe_when) {
        rules.push_back(value_rule_json(rule));
    }
    json["failsafe_when"] = std::move(rules);
    return json;
}

Json input_json(const InputConfig& input) {
    Json json = port_json(input.port, *input.protocol);
    json.update(supervision_json(input));
    for (const ChannelRule& rule : input.channels) {
        json["map"][std::to_string(rule.output + 1)] = channel_json(rule, {});
    }
    json.update(values_json(input.settings, protocol_keys(*input.protocol, SettingScope::input)));
    return json;
}

Json output_json(const OutputConfig& output) {
    SettingValues values;
    const bool grid = output.schedule.kind == ScheduleKind::grid;
    const bool locked = output.schedule.phase == Phase::locked;
    values.set("period", output.schedule.period);
    values.set("force", output.force);
    values.set("schedule", std::string(grid ? "grid" : "follow"));
    values.set("phase", std::string(locked ? "locked" : "free"));
    Json json = port_json(output.port, *output.protocol);
    json.update(values_json(values, output_keys()));
    if (output.port.link == LinkKind::can) {
        json["foreign_sender"] = output.yield_to_foreign_sender ? "failsafe" : "ignore";
    }
    json.update(
        values_json(output.settings, protocol_keys(*output.protocol, SettingScope::output)));
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
    SettingValues values;
    const std::string action = failsafe.action == FailsafeAction::preset ? "preset"
                               : failsafe.action == FailsafeAction::hold ? "hold"
                                                                         : "silence";
    values.set("hold", failsafe.hold);
    values.set("action", action);
    values.set("recover", failsafe.recover);
    values.set("power_on", failsafe.power_on);
    if (failsafe.slew_us_per_second) {
        values.set("slew", *failsafe.slew_us_per_second);
    }
    Json json = values_json(values, output_failsafe_keys());
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
    SettingValues values;
    const SelectionSettings& selection = pipeline.selection;
    json["from"] = names_json(pipeline.selection.inputs, configuration.inputs);
    json["to"] = names_json(pipeline.outputs, configuration.outputs);
    values.set("mode",
               std::string(key_rows::kModeChoices[static_cast<std::size_t>(selection.mode)]));
    if (selection.mode == SelectionMode::median) {
        values.set("tolerance", selection.tolerance.microseconds());
    }
    if (selection.changeover_us_per_second) {
        values.set("changeover", *selection.changeover_us_per_second);
    }
    json.update(values_json(values, pipeline_keys()));
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
    json["runtime"] = values_json(runtime_values(configuration.runtime), runtime_keys());
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
        json["gpio"][line.name] = line_json(line, configuration);
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
        json["recorder"] = recorder_json(*configuration.recorder);
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
