#include "app/recording_plan.h"

#include <filesystem>
#include <map>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/simulate_inputs.h"
#include "config/effective.h"

namespace tribus {
namespace {

using Json = nlohmann::json;

RecordedPort plan_port(const Configuration& configuration, const PortPlan& plan) {
    RecordedPort port{.ring = nullptr,
                      .can = plan.config.link == LinkKind::can,
                      .device = plan.config.device,
                      .byte_time = plan.config.line.bytes_time(1),
                      .read_file = {},
                      .written_file = {}};
    const PortWiring& wiring = plan.wiring;
    if (port.can) {
        port.read_file = port.device + "-in.log";
        port.written_file = port.device + "-out.log";
        return port;
    }
    if (!wiring.sensor_buses.empty()) {
        const std::string& bus = configuration.sensor_buses[wiring.sensor_buses.front()].name;
        port.read_file = fmt::format("sensor_bus-{}-in.txt", bus);
        port.written_file = fmt::format("sensor_bus-{}-out.txt", bus);
    }
    if (!wiring.inputs.empty()) {
        port.read_file =
            fmt::format("input-{}.txt", configuration.inputs[wiring.inputs.front()].name);
    }
    if (!wiring.outputs.empty()) {
        port.written_file =
            fmt::format("output-{}.txt", configuration.outputs[wiring.outputs.front()].name);
    }
    return port;
}

std::string replay_command(const Configuration& configuration,
                           const std::vector<RecordedPort>& ports) {
    std::string command = "tribus simulate config.toml";
    for (const SimulatedSource& source : simulated_sources(configuration)) {
        for (const RecordedPort& port : ports) {
            if (port.device == source.port->device && !port.read_file.empty()) {
                command += fmt::format(" --in {}={}", source.name, port.read_file);
            }
        }
    }
    for (const OutputConfig& output : configuration.outputs) {
        command += fmt::format(" --out {0}=simulated-{0}.{1}", output.name,
                               output.port.link == LinkKind::can ? "log" : "txt");
    }
    return command;
}

/// Files that the configuration names, as neighbours of the recorded one.
class NamedFiles {
  public:
    void take(SettingFile& file) {
        const auto [known, fresh] = names_.try_emplace(file.path);
        if (fresh) {
            const std::string name = std::filesystem::path(file.path).filename().string();
            known->second = fmt::format("config-{}-{}", names_.size(), name);
            files_.push_back({known->second, file.content});
        }
        file.path = known->second;
    }
    void take(SettingValues& values) {
        SettingValues taken;
        for (const auto& [key, value] : values) {
            SettingValue copy = value;
            if (auto* file = std::get_if<SettingFile>(&copy)) {
                take(*file);
            }
            taken.set(key, std::move(copy));
        }
        values = std::move(taken);
    }
    std::vector<SideFile>& files() { return files_; }

  private:
    std::map<std::string, std::string> names_;
    std::vector<SideFile> files_;
};

std::vector<SideFile> configuration_files(Configuration configuration) {
    NamedFiles named;
    for (InputConfig& input : configuration.inputs) {
        named.take(input.settings);
    }
    for (OutputConfig& output : configuration.outputs) {
        named.take(output.settings);
    }
    for (ValuesConfig& values : configuration.values) {
        auto* message = std::get_if<ValueMessageConfig>(&values.source);
        auto* source = message == nullptr ? nullptr : std::get_if<DbcValueSource>(&message->layout);
        if (source != nullptr) {
            named.take(source->dbc);
        }
    }
    std::vector<SideFile> files = std::move(named.files());
    files.push_back({"config.toml", effective_toml(configuration)});
    return files;
}

}  // namespace

RecordingPlan plan_recording(const Configuration& configuration, const std::vector<PortPlan>& ports,
                             Instant begin) {
    RecordingPlan plan;
    for (const PortPlan& port : ports) {
        plan.ports.push_back(plan_port(configuration, port));
    }
    plan.files = configuration_files(configuration);
    plan.replay = replay_command(configuration, plan.ports);
    plan.begin = begin;
    return plan;
}

std::string plan_to_text(const RecordingPlan& plan) {
    Json json;
    json["begin_ns"] = plan.begin.time_since_epoch().count();
    json["replay"] = plan.replay;
    json["ports"] = Json::array();
    for (const RecordedPort& port : plan.ports) {
        json["ports"].push_back({{"can", port.can},
                                 {"device", port.device},
                                 {"byte_time_ns", port.byte_time.count()},
                                 {"read_file", port.read_file},
                                 {"written_file", port.written_file}});
    }
    json["files"] = Json::array();
    for (const SideFile& file : plan.files) {
        json["files"].push_back({{"name", file.name}, {"content", file.content}});
    }
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<RecordingPlan> plan_from_text(std::string_view text) {
    // The library throws where a key is missing or of another kind.
    try {
        const Json json = Json::parse(text);
        RecordingPlan plan;
        plan.begin = Instant(Duration(json.at("begin_ns").get<std::int64_t>()));
        plan.replay = json.at("replay").get<std::string>();
        for (const Json& port : json.at("ports")) {
            plan.ports.push_back(
                {.ring = nullptr,
                 .can = port.at("can").get<bool>(),
                 .device = port.at("device").get<std::string>(),
                 .byte_time = Duration(port.at("byte_time_ns").get<std::int64_t>()),
                 .read_file = port.at("read_file").get<std::string>(),
                 .written_file = port.at("written_file").get<std::string>()});
        }
        for (const Json& file : json.at("files")) {
            plan.files.push_back(
                {file.at("name").get<std::string>(), file.at("content").get<std::string>()});
        }
        return plan;
    } catch (const Json::exception&) {
        return std::nullopt;
    }
}

}  // namespace tribus
