#include "app/web/recordings/plot_recording.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/object_text.h"
#include "app/cli/protocol_use.h"
#include "app/cli/streams.h"
#include "app/recorder/recording_plan.h"
#include "app/replay/simulate_inputs.h"
#include "app/web/recordings/plot_states.h"
#include "app/wire/frames/frame_finder.h"
#include "config/build/build.h"
#include "config/language/read_document.h"
#include "config/language/read_file.h"
#include "config/load.h"
#include "transports/recordings/burst_reader.h"
#include "transports/recordings/candump.h"

namespace tribus::web {
namespace {

namespace fs = std::filesystem;

/// An output that sends nothing for so long has stopped, whatever its period.
constexpr Duration kLeastGap = std::chrono::milliseconds(100);
constexpr int kMissedPeriods = 3;

/// One file of the recording, and what of it is drawn.
struct PlottedFile {
    std::string name;
    std::string path;
    bool can = false;
    std::vector<ProtocolUse> uses;
    std::vector<std::size_t> series;  ///< indices of the plot's, one for each use
};

bool is_regular(const fs::path& path) {
    std::error_code error;
    return fs::symlink_status(path, error).type() == fs::file_type::regular;
}

tl::expected<Configuration, std::string> configuration_of(const fs::path& folder) {
    const fs::path path = folder / "config.toml";
    auto text = is_regular(path) ? read_file(path, kMostConfigurationBytes)
                                 : tl::unexpected<std::string>("it is not there");
    if (!text) {
        return tl::unexpected("config.toml of the recording cannot be read: " + text.error());
    }
    auto configuration = load_configuration(*text, path.string());
    if (!configuration) {
        return tl::unexpected("the configuration of the recording has mistakes: " +
                              configuration.error().front().text);
    }
    return *std::move(configuration);
}

/// Whether what a port of this configuration sends can be read back.
bool can_decode(const Protocol& protocol, const SettingValues& settings) {
    return protocol.make_decoder != nullptr &&
           (protocol.check == nullptr || protocol.check(settings, SettingScope::input).empty());
}

/// Reads until `burst` or `frame` returns false. Returns where the file is damaged.
template <class TakeBurst, class TakeFrame>
std::optional<std::string> read_items(const PlottedFile& file, TakeBurst take_burst,
                                      TakeFrame take_frame) {
    auto pieces = FilePieces::open_path(file.path);
    if (!pieces) {
        return pieces.error();
    }
    if (file.can) {
        CandumpFrames frames(**pieces, file.name);
        auto frame = frames.next();
        while (frame && *frame && take_frame(**frame)) {
            frame = frames.next();
        }
        return frame ? (*pieces)->failed() : std::optional(frame.error());
    }
    BurstReader bursts(**pieces, file.name, RecordingKind::timed);
    auto burst = bursts.next();
    while (burst && *burst && take_burst(**burst)) {
        burst = bursts.next();
    }
    return burst ? (*pieces)->failed() : std::optional(burst.error());
}

/// The files, in the order of the ports, and the series of the plot.
class Reading {
  public:
    Reading(const fs::path& folder, const Configuration& configuration)
        : folder_(folder),
          configuration_(configuration),
          ports_(plan_recording(configuration, plan_ports(configuration), Instant{}).ports) {}

    tl::expected<RecordingPlot, std::string> read(const PlotOrder& order);

  private:
    void find_files();
    void measure();
    void draw(PlottedFile& file);
    void simulate();
    void note(std::optional<std::string> problem) {
        if (!plot_.problem) {
            plot_.problem = std::move(problem);
        }
    }
    template <class Configs>
    void add_file(const RecordedPort& port, const std::string& name, const Configs& configs);

    fs::path folder_;
    const Configuration& configuration_;
    std::vector<RecordedPort> ports_;
    std::vector<PlottedFile> files_;
    RecordingPlot plot_;
};

Duration gap_of(const InputConfig& input) {
    return input.supervision.timeout;
}
Duration gap_of(const OutputConfig& output) {
    return std::max(kMissedPeriods * output.schedule.period, kLeastGap);
}

template <class Configs>
void Reading::add_file(const RecordedPort& port, const std::string& name, const Configs& configs) {
    const fs::path path = folder_ / name;
    if (name.empty() || !is_regular(path)) {
        return;
    }
    PlottedFile file{
        .name = name, .path = path.string(), .can = port.can, .uses = {}, .series = {}};
    for (const auto& config : configs) {
        if (config.port.device != port.device || !can_decode(*config.protocol, config.settings)) {
            continue;
        }
        constexpr bool kIsInput = requires {
            config.supervision;
        };
        file.uses.push_back({config.protocol, config.settings, config.port.line});
        file.series.push_back(plot_.series.size());
        plot_.series.push_back(
            {config.name, kIsInput ? "input" : "output", PlotFrames(PlotSpan{}, gap_of(config))});
    }
    files_.push_back(std::move(file));
}

void Reading::find_files() {
    for (const RecordedPort& port : ports_) {
        add_file(port, port.read_file, configuration_.inputs);
    }
    for (const RecordedPort& port : ports_) {
        add_file(port, port.written_file, configuration_.outputs);
    }
}

/// Finds the length of the recording: the picture has columns for what is there.
void Reading::measure() {
    for (const PlottedFile& file : files_) {
        const auto look = [this](Duration at) {
            const bool possible = at <= kLongestPlot;
            plot_.length = possible ? std::max(plot_.length, at) : plot_.length;
            return possible;
        };
        note(read_items(
            file, [&](const Burst& burst) { return look(burst.start.value_or(Duration{})); },
            [&](const RecordedCanFrame& frame) { return look(frame.at); }));
    }
    // The last item has a place in the picture, too.
    plot_.length += std::chrono::microseconds(1);
}

void Reading::draw(PlottedFile& file) {
    std::vector<std::unique_ptr<FrameFinder>> finders;
    for (std::size_t i = 0; i < file.uses.size(); ++i) {
        PlotFrames& frames = plot_.series[file.series[i]].frames;
        finders.push_back(make_frame_finder(file.uses[i], [&frames](const FoundFrame& found) {
            frames.take(found.start.value_or(Duration{}), found.frame.channels);
        }));
    }
    std::size_t index = 0;
    read_items(
        file,
        [&](const Burst& burst) {
            for (const auto& finder : finders) {
                finder->feed_burst(index, burst);
            }
            ++index;
            return burst.start.value_or(Duration{}) < plot_.span.to;
        },
        [&](const RecordedCanFrame& frame) {
            for (const auto& finder : finders) {
                finder->feed_frame(frame);
            }
            return frame.at < plot_.span.to;
        });
    for (std::size_t i = 0; i < finders.size(); ++i) {
        finders[i]->finish();
        plot_.series[file.series[i]].frames.finish(plot_.length);
    }
}

void Reading::simulate() {
    const auto sources = simulated_sources(configuration_);
    std::map<std::size_t, std::string> files;
    for (std::size_t i = 0; i < sources.size(); ++i) {
        for (const RecordedPort& port : ports_) {
            const fs::path path = folder_ / port.read_file;
            if (port.device == sources[i].port->device && !port.read_file.empty() &&
                is_regular(path)) {
                files[i] = path.string();
            }
        }
    }
    note(simulate_states(configuration_, sources, files, plot_));
}

tl::expected<RecordingPlot, std::string> Reading::read(const PlotOrder& order) {
    find_files();
    if (files_.empty()) {
        return tl::unexpected<std::string>("the recording has no file of an input or output");
    }
    measure();
    plot_.span.to = std::min(order.to, plot_.length);
    plot_.span.from = std::min(order.from, plot_.span.to);
    plot_.span.columns = plot_.span.from < plot_.span.to ? order.columns : 0;
    for (PlotSeries& series : plot_.series) {
        series.frames.show(plot_.span);
    }
    for (PlottedFile& file : files_) {
        draw(file);
    }
    simulate();
    return std::move(plot_);
}

std::int64_t plot_us(Duration time) {
    return std::chrono::duration_cast<std::chrono::microseconds>(time).count();
}

void write_columns(const PlotCurve& curve, Pulse PlotColumn::*value, std::ostream& out) {
    std::string text;
    for (const PlotColumn& column : curve.columns()) {
        text += text.empty() ? "" : ",";
        text += column.empty() ? "null" : fmt::format("{}", (column.*value).microseconds());
    }
    out << text;
}

void write_series(const RecordingPlot& plot, std::ostream& out) {
    std::string_view comma;
    for (const PlotSeries& series : plot.series) {
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            const PlotCurve* const curve = series.frames.channel(channel);
            if (curve == nullptr) {
                continue;
            }
            out << comma << R"({"name":)" << json_text(series.name) << R"(,"kind":")" << series.kind
                << R"(","channel":)" << channel + 1 << R"(,"least":[)";
            write_columns(*curve, &PlotColumn::least, out);
            out << R"(],"greatest":[)";
            write_columns(*curve, &PlotColumn::greatest, out);
            out << "]}";
            comma = ",\n";
        }
    }
}

nlohmann::ordered_json states_json(const RecordingPlot& plot) {
    auto list = nlohmann::ordered_json::array();
    for (const PlottedStates& output : plot.states) {
        for (const PlotState& state : output.states.states()) {
            list.push_back({{"output", output.output},
                            {"from_us", plot_us(state.from)},
                            {"to_us", plot_us(state.to)},
                            {"state", state.word}});
        }
    }
    return list;
}

}  // namespace

tl::expected<RecordingPlot, std::string> plot_recording(const fs::path& folder,
                                                        const PlotOrder& order) {
    const auto configuration = configuration_of(folder);
    if (!configuration) {
        return tl::unexpected(configuration.error());
    }
    return Reading(folder, *configuration).read(order);
}

void write_plot(const RecordingPlot& plot, std::ostream& out) {
    std::size_t left_out = 0;
    for (const PlottedStates& output : plot.states) {
        left_out += output.states.left_out();
    }
    out << fmt::format(R"({{"from_us":{},"to_us":{},"length_us":{},)", plot_us(plot.span.from),
                       plot_us(plot.span.to), plot_us(plot.length))
        << R"("problem":)"
        << json_text(plot.problem ? nlohmann::ordered_json(*plot.problem)
                                  : nlohmann::ordered_json(nullptr))
        << R"(,"states_left_out":)" << left_out << R"(,"states":)" << json_text(states_json(plot))
        << R"(,"series":[)";
    write_series(plot, out);
    out << "]}\n";
}

}  // namespace tribus::web
