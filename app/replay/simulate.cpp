#include "app/replay/simulate.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <tl/expected.hpp>

#include "app/cli/exit_status.h"
#include "app/cli/load_or_explain.h"
#include "app/journal/print_error.h"
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

/// The files of --out, which are written while the simulation runs.
class SinkFiles {
  public:
    /// Opens the file of each index. The error says which one cannot be opened.
    static tl::expected<SinkFiles, std::string> open(
        const std::map<std::size_t, std::string>& paths, std::size_t sinks) {
        SinkFiles files(sinks);
        for (const auto& [sink, path] : paths) {
            files.sinks_[sink] = std::make_unique<Sink>(path);
            if (files.sinks_[sink]->failed()) {
                return tl::unexpected(cannot_write(path));
            }
        }
        return files;
    }

    bool wants(std::size_t sink) const { return sinks_[sink] != nullptr; }
    /// The text that is not written yet. Append to it, then call `appended`.
    std::string& text(std::size_t sink) { return sinks_[sink]->text; }
    void appended(std::size_t sink) {
        constexpr std::size_t kMostKept = std::size_t{64} * 1024;
        if (sinks_[sink]->text.size() >= kMostKept) {
            sinks_[sink]->write();
        }
    }
    /// Writes the rest. Returns false, with a message, if a file is not complete.
    bool finish() {
        bool fine = true;
        for (const auto& sink : sinks_) {
            if (sink != nullptr && !sink->finish()) {
                print_error("{}\n", cannot_write(sink->path));
                fine = false;
            }
        }
        return fine;
    }

  private:
    struct Sink {
        explicit Sink(const std::string& to) : path(to) {
            if (path != "-") {
                file.open(path, std::ios::binary);
            }
        }
        bool failed() const { return path != "-" && !file.is_open(); }
        void write() {
            if (path == "-") {
                fmt::print("{}", text);
            } else {
                file << text;
            }
            text.clear();
        }
        bool finish() {
            write();
            return path == "-" || static_cast<bool>(file.flush());
        }

        std::string path;
        std::ofstream file;
        std::string text;
    };

    explicit SinkFiles(std::size_t sinks) : sinks_(sinks) {}

    static std::string cannot_write(const std::string& path) {
        return fmt::format(
            "{}: cannot be written; check that its folder exists and the disk is not full", path);
    }

    std::vector<std::unique_ptr<Sink>> sinks_;
};

/// Writes what outputs and sensor buses send: CAN frames as candump log, bytes in the requested
/// format. Prints changes of state.
class SinkRecorder final : public StationObserver {
  public:
    SinkRecorder(const Engine& engine, const std::vector<SimulatedSink>& sinks, SinkFiles& files,
                 std::string_view format)
        : sinks_(sinks),
          first_bus_(engine.outputs().size()),
          files_(files),
          format_(format),
          log_(engine) {
        for (std::size_t sink = 0; sink < sinks.size(); ++sink) {
            if (files.wants(sink) && format_ == "timed" &&
                sinks[sink].port->medium->shape == WireShape::bytes) {
                files.text(sink) = kTimedHeading;
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
        if (!files_.wants(sink)) {
            return;
        }
        std::string& text = files_.text(sink);
        for (const CanFrame& frame : sent.can_frames()) {
            append_candump_line(text, at.time_since_epoch(), sinks_[sink].port->device, frame);
        }
        if (!sent.bytes().empty()) {
            append(text, at, sent.bytes());
        }
        files_.appended(sink);
    }
    void polled(Instant at) override { log_.look(at); }

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
    SinkFiles& files_;
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

/// Says which file of --out is one of --in, or another one of --out. It would be overwritten while
/// it is used.
std::optional<std::string> file_used_twice(const std::map<std::size_t, std::string>& in,
                                           const std::map<std::size_t, std::string>& out) {
    const auto same = [](const std::string& one, const std::string& other) {
        std::error_code none;
        return one != "-" && (one == other || std::filesystem::equivalent(one, other, none));
    };
    for (auto written = out.begin(); written != out.end(); ++written) {
        const auto is_written = [&](const auto& other) {
            return same(written->second, other.second);
        };
        if (std::ranges::any_of(in, is_written)) {
            return fmt::format("--out {}: --in reads this file; write to another one",
                               written->second);
        }
        if (std::any_of(std::next(written), out.end(), is_written)) {
            return fmt::format("--out {}: two of them write to this file; give each its own",
                               written->second);
        }
    }
    return std::nullopt;
}

/// The error says where a recording cannot be read; until there it was played.
tl::expected<void, std::string> play(VirtualLoop& loop, Arrivals& arrivals,
                                     std::span<const SimulatedSource> sources, Duration tail) {
    auto arrival = arrivals.next();
    for (; arrival && *arrival != nullptr; arrival = arrivals.next()) {
        arrive(loop, sources[(*arrival)->source], **arrival);
    }
    if (!arrival) {
        return tl::unexpected(arrival.error());
    }
    loop.run_until(later(loop.now(), tail));
    return {};
}

void print_buses(const Configuration& configuration, const ValueEngine& values) {
    for (std::size_t bus = 0; bus < values.bus_count(); ++bus) {
        const SensorBusState state = values.bus_state(bus);
        const std::string& name = configuration.sensor_buses[bus].name;
        if (state.is_receiver) {
            print_error("sensor bus {}: {}, {}, {} found\n", name,
                        counted(state.receiver.requests, "request"),
                        counted(state.receiver.replies, "reply", "replies"),
                        counted(state.found_count, "sensor"));
        } else {
            print_error("sensor bus {}: {}, {} answered, {} without a value\n", name,
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
        print_error("input {}: {}, {}, {} rejected\n", input.name(),
                    counted(input.counts().bytes, "byte"), counted(input.counts().frames, "frame"),
                    rejected);
    }
    for (const Output& output : engine.outputs()) {
        print_error("output {}: {}, {} into failsafe, {}\n", output.name(),
                    counted(output.counts().frames, "frame"),
                    counted(output.counts().failsafe_entries, "time"),
                    counted(output.counts().recoveries, "recovery", "recoveries"));
    }
}

int simulate(const SimulateOptions& options) {
    const auto complain = [](const std::string& text, int status) {
        print_error("{}\n", text);
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
    auto arrivals = Arrivals::open(*in, sources);
    if (!arrivals) {
        return complain(arrivals.error(), kExitFailed);
    }
    if (const auto clash = file_used_twice(*in, *out)) {
        return complain(*clash, kExitWrongUse);
    }
    auto files = SinkFiles::open(*out, sinks.size());
    if (!files) {
        return complain(files.error(), kExitFailed);
    }
    for (const std::string& rest : arrivals->rests()) {
        print_error("{}\n", rest);
    }
    const auto engine = build_engine(*configuration);
    const auto values = build_value_engine(*configuration, *engine);
    SinkRecorder recorder(*engine, sinks, *files, options.format);
    VirtualLoop loop(*engine, recorder, Instant{}, values.get());
    if (auto played = play(loop, *arrivals, sources, *tail); !played) {
        files->finish();
        return complain(played.error(), kExitFailed);
    }
    print_summary(*engine);
    if (values) {
        print_buses(*configuration, *values);
    }
    return files->finish() ? kExitFine : kExitFailed;
}

}  // namespace

Command simulate_command() {
    auto options = std::make_shared<SimulateOptions>();
    return {
        .name = "simulate",
        .help = "Run a configuration over recorded inputs, in virtual time",
        .notes =
            "An input without --in stays silent. Only these files are opened. Each recording "
            "starts with the simulation. If several CAN inputs received at the same time, give one "
            "log with all their frames to each of them with --in.",
        .options = {configuration_option(options->config),
                    {.name = "--in",
                     .value = &options->in,
                     .help = "Recorded bytes of an input or sensor bus, or the candump log of a "
                             "CAN input or of the message of [values.NAME]",
                     .value_name = "NAME=FILE"},
                    {.name = "--out",
                     .value = &options->out,
                     .help = "File for what an output or a sensor bus sends; - for standard "
                             "output",
                     .value_name = "NAME=FILE"},
                    {.name = "--format",
                     .value = &options->format,
                     .help = "Format of the outputs; CAN outputs are always candump logs",
                     .shows_value = true,
                     .choices = {"timed", "hex", "binary"}},
                    {.name = "--tail",
                     .value = &options->tail,
                     .help = "How long to go on after the last input",
                     .shows_value = true,
                     .value_name = "DURATION"}},
        .examples = {{"tribus simulate servos.toml --in receiver=receiver.txt --out servos=out.txt",
                      "says when the input was lost, and writes what the servos would get"},
                     {"tribus simulate servos.toml --in receiver=loss.txt --tail 5s", ""}},
        .run = [options] { return simulate(*options); },
    };
}

}  // namespace tribus
