#include "app/recorder/recording_plan.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <set>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/replay/simulate_inputs.h"
#include "config/show/effective.h"

namespace tribus {
namespace {

using Json = nlohmann::json;

/// 146 years of uptime.
constexpr std::uint64_t kMostNanoseconds = std::uint64_t{1} << 62U;

bool is_plain(char c) {
    return std::isprint(static_cast<unsigned char>(c)) != 0 && c != '/';
}

/// Name of the [values.NAME] with that index among those with messages.
std::string_view name_of_message(const Configuration& configuration, std::size_t index) {
    for (const ValuesConfig& values : configuration.values) {
        const bool has_messages = std::holds_alternative<ValueMessageConfig>(values.source);
        if (has_messages && index-- == 0) {
            return values.name;
        }
    }
    return {};
}

RecordedPort plan_port(const Configuration& configuration, const PortPlan& plan) {
    RecordedPort port{.ring = plan.wiring.capture,
                      .can = plan.config.medium->shape == WireShape::can_frames,
                      .device = plan.config.device,
                      .byte_time = plan.config.line.bytes_time(1),
                      .read_file = {},
                      .written_file = {},
                      .ring_file = {}};
    const std::span stations(plan.wiring.stations);
    if (port.can) {
        port.read_file = port.device + "-in.log";
        port.written_file = port.device + "-out.log";
        return port;
    }
    if (const auto index = first_of(stations, StationKind::sensor_bus)) {
        const std::string& bus = configuration.sensor_buses[*index].name;
        port.read_file = fmt::format("sensor_bus-{}-in.txt", bus);
        port.written_file = fmt::format("sensor_bus-{}-out.txt", bus);
    }
    if (const auto index = first_of(stations, StationKind::replies)) {
        port.read_file = fmt::format("output-{}-heard.txt", configuration.outputs[*index].name);
    }
    if (const auto index = first_of(stations, StationKind::input)) {
        port.read_file = fmt::format("input-{}.txt", configuration.inputs[*index].name);
    }
    if (const auto index = first_of(stations, StationKind::value_message)) {
        port.read_file = fmt::format("values-{}.txt", name_of_message(configuration, *index));
    }
    if (const auto index = first_of(stations, StationKind::answers)) {
        port.written_file = fmt::format("input-{}-answers.txt", configuration.inputs[*index].name);
    }
    if (const auto index = first_of(stations, StationKind::output)) {
        port.written_file = fmt::format("output-{}.txt", configuration.outputs[*index].name);
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
                               output.port.medium->shape == WireShape::can_frames ? "log" : "txt");
    }
    return command;
}

/// File name of `path`, shortened, without unusual characters.
std::string plain_name(const std::string& path) {
    constexpr std::size_t kLongest = 100;
    std::string name = std::filesystem::path(path).filename().string();
    name.erase(0, name.size() - std::min(name.size(), kLongest));
    std::ranges::replace_if(
        name, [](char c) { return !is_plain(c); }, '_');
    return name;
}

/// Files that the configuration names; the recording holds copies of them beside the configuration.
class NamedFiles {
  public:
    void take(SettingFile& file) {
        const auto [known, fresh] = names_.try_emplace(file.path);
        if (fresh) {
            known->second = fmt::format("config-{}-{}", names_.size(), plain_name(file.path));
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

/// -1 if it is not a number or out of range.
Duration nanoseconds_in(const Json& json) {
    return json.is_number_unsigned() && json.get<std::uint64_t>() <= kMostNanoseconds
               ? Duration(json.get<std::int64_t>())
               : Duration(-1);
}

bool is_line(const std::string& text) {
    return std::ranges::none_of(
        text, [](char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; });
}

/// Names of files in one folder.
class Names {
  public:
    /// False if the name leaves the folder or is taken.
    bool take(const std::string& name) {
        return !name.empty() && name.size() <= kLongest && name != "." && name != ".." &&
               is_line(name) && name.find('/') == std::string::npos && taken_.insert(name).second;
    }

  private:
    static constexpr std::size_t kLongest = 200;
    std::set<std::string> taken_;
};

bool is_sound(const RecordingPlan& plan) {
    constexpr Duration kLongestByte = std::chrono::seconds(1);
    Names recorded;
    recorded.take("README.txt");
    Names rings;
    const bool ports = std::ranges::all_of(plan.ports, [&](const RecordedPort& port) {
        return port.byte_time >= Duration::zero() && port.byte_time <= kLongestByte &&
               is_line(port.device) && (port.read_file.empty() || recorded.take(port.read_file)) &&
               (port.written_file.empty() || recorded.take(port.written_file)) &&
               rings.take(port.ring_file);
    });
    return ports && plan.begin >= Instant{} && is_line(plan.replay) &&
           std::ranges::all_of(plan.lacks, is_line) &&
           std::ranges::all_of(plan.files,
                               [&](const SideFile& file) { return recorded.take(file.name); });
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
    json["lacks"] = plan.lacks;
    json["ports"] = Json::array();
    for (const RecordedPort& port : plan.ports) {
        json["ports"].push_back({{"can", port.can},
                                 {"device", port.device},
                                 {"byte_time_ns", port.byte_time.count()},
                                 {"read_file", port.read_file},
                                 {"written_file", port.written_file},
                                 {"ring_file", port.ring_file}});
    }
    json["files"] = Json::array();
    for (const SideFile& file : plan.files) {
        json["files"].push_back({{"name", file.name}, {"content", file.content}});
    }
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<RecordingPlan> plan_from_text(std::string_view text) {
    constexpr int kMostDepth = 4;
    constexpr std::size_t kMostValues = 100'000;
    std::size_t values = 0;
    // Values that are left out take no memory: a value needs many times that of its text.
    const auto fits = [&values](int depth, Json::parse_event_t /*event*/, Json& /*parsed*/) {
        return depth <= kMostDepth && ++values <= kMostValues;
    };
    // The library throws if a key is missing or has the wrong type.
    try {
        const Json json = Json::parse(text, fits);
        RecordingPlan plan;
        plan.begin = Instant(nanoseconds_in(json.at("begin_ns")));
        plan.replay = json.at("replay").get<std::string>();
        plan.lacks = json.at("lacks").get<std::vector<std::string>>();
        for (const Json& port : json.at("ports")) {
            plan.ports.push_back({.ring = nullptr,
                                  .can = port.at("can").get<bool>(),
                                  .device = port.at("device").get<std::string>(),
                                  .byte_time = nanoseconds_in(port.at("byte_time_ns")),
                                  .read_file = port.at("read_file").get<std::string>(),
                                  .written_file = port.at("written_file").get<std::string>(),
                                  .ring_file = port.at("ring_file").get<std::string>()});
        }
        for (const Json& file : json.at("files")) {
            plan.files.push_back(
                {file.at("name").get<std::string>(), file.at("content").get<std::string>()});
        }
        return is_sound(plan) ? std::optional(std::move(plan)) : std::nullopt;
    } catch (const Json::exception&) {
        return std::nullopt;
    }
}

}  // namespace tribus
