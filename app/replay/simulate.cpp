#include "app/replay/simulate.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <tl/expected.hpp>

#include "app/cli/exit_status.h"
#include "app/cli/load_or_explain.h"
#include "app/replay/simulate_inputs.h"
#include "app/replay/simulate_log.h"
#include "config/build/build.h"
#include "config/language/mistakes.h"
#include "config/schema/notation.h"
#include "core/counted.h"
#include "core/quotes.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "transports/recordings/writer.h"

namespace tribus {
namespace {

struct SimulateOptions {
    std::string config;
    std::vector<std::string> in;
    std::vector<std::string> out;
    std::string format = "timed";
    std::string tail = "2s";
};

/// Something whose output can be written to a file: outputs come first, then sensor buses.
struct SimulatedSink {
    std::string name;
    const PortConfig* port = nullptr;
};
std::vector<SimulatedSink> simulated_sinks(const Configuration& configuration) {
    std::vector<SimulatedSink> sinks;
    for (const OutputConfig& output : configuration.outputs) {
        sinks.push_back({output.name, &output.port});
    }
    for (const SensorBusConfig& bus : configuration.sensor_buses) {
        sinks.push_back({bus.name, &bus.port});
    }
    return sinks;
}

/// Keeps what outputs and sensor buses send: CAN frames as candump log, bytes in the requested
/// format. Prints changes of state.
class SinkRecorder final : public StationObserver {
  public:
    SinkRecorder(const Engine& engine, const std::vector<SimulatedSink>& sinks,
                 std::string_view format)
        : sinks_(sinks),
          first_bus_(engine.outputs().size()),
          texts_(sinks.size()),
          format_(format),
          log_(engine) {
        for (std::size_t sink = 0; sink < sinks.size(); ++sink) {
            if (format_ == "timed" && sinks[sink].port->medium->shape == WireShape::bytes) {
                texts_[sink] = kTimedHeading;
            }
        }
    }

    /// No file gets the frames of DroneCAN nodes.
    void wrote(Station station, Instant at, const Transmission& sent) override {
        if (station.kind == StationKind::dronecan_node) {
            return;
        }
        const std::size_t sink =
            station.kind == StationKind::sensor_bus ? first_bus_ + station.index : station.index;
        for (const CanFrame& frame : sent.can_frames()) {
            append_candump_line(texts_[sink], at.time_since_epoch(), sinks_[sink].port->device,
                                frame);
        }
        if (!sent.bytes().empty()) {
            append(texts_[sink], at, sent.bytes());
        }
    }
    void polled(Instant at) override { log_.look(at); }
    const std::string& text(std::size_t sink) const { return texts_[sink]; }

  private:
    void append(std::string& text, Instant at, std::span<const std::uint8_t> bytes) const {
        if (format_ == "timed") {
            append_timed_line(text, at.time_since_epoch(), bytes);
        } else if (format_ == "hex") {
            append_hex_line(text, bytes);
        } else {
            text.append(bytes.begin(), bytes.end());
        }
    }

    const std::vector<SimulatedSink>& sinks_;
    std::size_t first_bus_;
    std::vector<std::string> texts_;
    std::string format_;
    SimulateLog log_;
};

/// Parses `NAME=FILE`, each name at most once. The error says what is allowed.
template <class Configs>
tl::expected<std::map<std::size_t, std::string>, std::string> assign_files(
    const std::vector<std::string>& pairs, const Configs& configs, std::string_view option) {
    std::map<std::size_t, std::string> files;
    std::vector<std::string_view> names;
    names.reserve(configs.size());
    for (const auto& config : configs) {
        names.push_back(config.name);
    }
    for (const std::string& pair : pairs) {
        const std::size_t equals = pair.find('=');
        if (equals == std::string::npos) {
            return tl::unexpected(fmt::format("{} {}: must be NAME=FILE", option, pair));
        }
        const std::string_view name = std::string_view(pair).substr(0, equals);
        const auto found = std::find(names.begin(), names.end(), name);
        if (found == names.end()) {
            return tl::unexpected(fmt::format("{} {}: the configuration has no {}; {}", option,
                                              pair, in_quotes(name), suggestion(name, names)));
        }
        const auto index = static_cast<std::size_t>(found - names.begin());
        if (!files.emplace(index, pair.substr(equals + 1)).second) {
            return tl::unexpected(
                fmt::format("{} {}: {} is given twice", option, pair, in_quotes(name)));
        }
    }
    return files;
}

void arrive(VirtualLoop& loop, const SimulatedSource& source, const Arrival& arrival,
            const Arrivals& arrivals) {
    if (const auto* frame = std::get_if<ArrivedCanFrame>(&arrival.what)) {
        loop.receive(source.station, arrivals.can_frames[frame->index], arrival.at);
    } else if (const auto* byte = std::get_if<ArrivedByte>(&arrival.what)) {
        const std::span bytes(&byte->value, 1);
        const std::array damaged{byte->damaged};
        if (byte->untimed && source.station.kind == StationKind::input) {
            loop.forget_read_time(source.station.index);
        }
        loop.receive(source.station, bytes, damaged, arrival.at);
    }
}

void play(VirtualLoop& loop, const Arrivals& arrivals, std::span<const SimulatedSource> sources,
          Duration tail) {
    for (const Arrival& arrival : arrivals.in_order) {
        arrive(loop, sources[arrival.source], arrival, arrivals);
    }
    loop.run_until(later(loop.now(), tail));
}

bool write_outputs(const std::map<std::size_t, std::string>& files, const SinkRecorder& recorder) {
    bool fine = true;
    for (const auto& [index, path] : files) {
        if (path == "-") {
            fmt::print("{}", recorder.text(index));
            continue;
        }
        std::ofstream file(path, std::ios::binary);
        file << recorder.text(index);
        if (!file.flush()) {
            fmt::print(
                stderr,
                "{}: cannot be written; check that its folder exists and the disk is not full\n",
                path);
            fine = false;
        }
    }
    return fine;
}

void print_buses(const Configuration& configuration, const ValueEngine& values) {
    for (std::size_t bus = 0; bus < values.bus_count(); ++bus) {
        const SensorBusState state = values.bus_state(bus);
        const std::string& name = configuration.sensor_buses[bus].name;
        if (state.is_receiver) {
            fmt::print(stderr, "sensor bus {}: {}, {}, {} found\n", name,
                       counted(state.receiver.requests, "request"),
                       counted(state.receiver.replies, "reply", "replies"),
                       counted(state.found_count, "sensor"));
        } else {
            fmt::print(stderr, "sensor bus {}: {}, {} answered, {} without a value\n", name,
                       counted(state.sensor.requests, "request"), state.sensor.answered,
                       state.sensor.stale);
        }
    }
}

void print_summary(const Engine& engine) {
    for (const Input& input : engine.inputs()) {
        std::uint64_t rejected = 0;
        for (const NamedCount& cause : input.decoder().rejected()) {
            rejected += cause.count;
        }
        fmt::print(stderr, "input {}: {}, {}, {} rejected\n", input.name(),
                   counted(input.counts().bytes, "byte"), counted(input.counts().frames, "frame"),
                   rejected);
    }
    for (const Output& output : engine.outputs()) {
        fmt::print(stderr, "output {}: {}, {} into failsafe, {}\n", output.name(),
                   counted(output.counts().frames, "frame"),
                   counted(output.counts().failsafe_entries, "time"),
                   counted(output.counts().recoveries, "recovery", "recoveries"));
    }
}

int simulate(const SimulateOptions& options) {
    const auto complain = [](const std::string& text, int status) {
        fmt::print(stderr, "{}\n", text);
        return status;
    };
    const auto configuration = load_or_explain(options.config);
    if (!configuration) {
        return kExitWrongUse;
    }
    const auto sources = simulated_sources(*configuration);
    const auto sinks = simulated_sinks(*configuration);
    const auto in = assign_files(options.in, sources, "--in");
    if (!in) {
        return complain(in.error(), kExitWrongUse);
    }
    const auto out = assign_files(options.out, sinks, "--out");
    if (!out) {
        return complain(out.error(), kExitWrongUse);
    }
    const auto tail = parse_duration(options.tail);
    if (!tail) {
        return complain(
            fmt::format("--tail {}: must be a duration such as 2s or 500ms", options.tail),
            kExitWrongUse);
    }
    const auto arrivals = load_arrivals(*in, sources);
    if (!arrivals) {
        return complain(arrivals.error(), kExitFailed);
    }
    const auto engine = build_engine(*configuration);
    const auto values = build_value_engine(*configuration, *engine);
    SinkRecorder recorder(*engine, sinks, options.format);
    VirtualLoop loop(*engine, recorder, Instant{}, values.get());
    play(loop, *arrivals, sources, *tail);
    print_summary(*engine);
    if (values) {
        print_buses(*configuration, *values);
    }
    return write_outputs(*out, recorder) ? kExitFine : kExitFailed;
}

}  // namespace

Command simulate_command() {
    auto options = std::make_shared<SimulateOptions>();
    return {
        .name = "simulate",
        .help = "Run a configuration over recorded inputs, in virtual time",
        .footer =
            "An input without --in stays silent. Only these files are opened. Each recording "
            "starts with the simulation. If several CAN inputs received at the same time, give one "
            "log with all their frames to each of them with --in.",
        .options = {{.name = "CONFIG",
                     .value = &options->config,
                     .help = "Configuration file",
                     .required = true},
                    {.name = "--in",
                     .value = &options->in,
                     .help = "NAME=FILE: recorded bytes of an input or sensor bus, or the candump "
                             "log of a CAN input or of the message of [values.NAME] (repeatable)",
                     .type_name = "NAME=FILE"},
                    {.name = "--out",
                     .value = &options->out,
                     .help = "NAME=FILE: file for what an output or a sensor bus sends; - for "
                             "standard output (repeatable)",
                     .type_name = "NAME=FILE"},
                    {.name = "--format",
                     .value = &options->format,
                     .help = "Format of the outputs; CAN outputs are always candump logs",
                     .shows_value = true,
                     .choices = {"timed", "hex", "binary"}},
                    {.name = "--tail",
                     .value = &options->tail,
                     .help = "How long to go on after the last input",
                     .shows_value = true}},
        .run = [options] { return simulate(*options); },
    };
}

}  // namespace tribus
