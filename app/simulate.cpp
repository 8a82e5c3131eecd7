#include "app/simulate.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <tl/expected.hpp>

#include "app/exit_status.h"
#include "app/load_or_explain.h"
#include "config/build.h"
#include "config/mistakes.h"
#include "config/values.h"
#include "pipelines/virtual_loop.h"
#include "transports/links/recording.h"
#include "transports/links/recording_writer.h"

namespace tribus {
namespace {

struct Options {
    std::string config;
    std::vector<std::string> in;
    std::vector<std::string> out;
    std::string format = "timed";
    std::string tail = "2s";
};

/// One byte that arrives at an input, at the instant at which its last bit is there.
struct Arrival {
    Instant at;
    std::size_t input = 0;
    std::uint8_t byte = 0;
    bool damaged = false;
};

/// Keeps what each output wrote, as text or bytes in the asked format.
class Recorder final : public OutputObserver {
  public:
    Recorder(std::size_t outputs, std::string_view format)
        : texts_(outputs, format == "timed" ? std::string(kTimedHeading) : std::string()),
          format_(format) {}

    void wrote(std::size_t output, Instant at, const Transmission& sent) override {
        const auto frame = sent.bytes;
        std::string& text = texts_[output];
        if (format_ == "timed") {
            append_timed_line(text, at.time_since_epoch(), frame);
        } else if (format_ == "hex") {
            append_hex_line(text, frame);
        } else {
            text.append(frame.begin(), frame.end());
        }
    }
    const std::string& text(std::size_t output) const { return texts_[output]; }

  private:
    std::vector<std::string> texts_;
    std::string format_;
};

tl::expected<std::string, std::string> read_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream content;
    if (!file || !(content << file.rdbuf()).good()) {
        return tl::unexpected(path + ": cannot be read; is it there, and a file?");
    }
    return content.str();
}

/// `NAME=FILE` for each name at most once; the error says what is allowed.
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
            return tl::unexpected(fmt::format("{} {}: wants NAME=FILE", option, pair));
        }
        const std::string_view name = std::string_view(pair).substr(0, equals);
        const auto found = std::find(names.begin(), names.end(), name);
        if (found == names.end()) {
            return tl::unexpected(fmt::format("{} {}: the configuration has no \"{}\"; {}", option,
                                              pair, name, suggestion(name, names)));
        }
        const auto index = static_cast<std::size_t>(found - names.begin());
        if (!files.emplace(index, pair.substr(equals + 1)).second) {
            return tl::unexpected(
                fmt::format("{} {}: \"{}\" was given before", option, pair, name));
        }
    }
    return files;
}

/// A recording without times is played with its bursts the protocol's usual period apart.
void add_arrivals(std::vector<Arrival>& arrivals, const Recording& recording, std::size_t index,
                  const InputConfig& input) {
    Duration untimed{};
    for (const Burst& burst : recording.bursts) {
        const Duration start = burst.start.value_or(untimed);
        for (std::size_t i = 0; i < burst.bytes.size(); ++i) {
            arrivals.push_back({Instant(start + input.port.line.bytes_time(i + 1)), index,
                                burst.bytes[i], burst.damaged[i]});
        }
        untimed += std::max(input.protocol->default_period,
                            input.port.line.bytes_time(burst.bytes.size() + 1));
    }
}

tl::expected<std::vector<Arrival>, std::string> load_arrivals(
    const std::map<std::size_t, std::string>& files, const Configuration& configuration) {
    std::vector<Arrival> arrivals;
    for (const auto& [index, path] : files) {
        const auto content = read_file(path);
        if (!content) {
            return tl::unexpected(content.error());
        }
        const auto recording = parse_recording(*content, path);
        if (!recording) {
            return tl::unexpected(recording.error());
        }
        add_arrivals(arrivals, *recording, index, configuration.inputs[index]);
    }
    std::stable_sort(arrivals.begin(), arrivals.end(),
                     [](const Arrival& a, const Arrival& b) { return a.at < b.at; });
    return arrivals;
}

void play(Engine& engine, Recorder& recorder, const std::vector<Arrival>& arrivals, Duration tail) {
    VirtualLoop loop(engine, recorder, Instant{});
    for (const Arrival& arrival : arrivals) {
        const std::array damaged{arrival.damaged};
        loop.receive(arrival.input, std::span(&arrival.byte, 1), damaged, arrival.at);
    }
    loop.run_until(later(loop.now(), tail));
}

bool write_outputs(const std::map<std::size_t, std::string>& files, const Recorder& recorder) {
    bool fine = true;
    for (const auto& [index, path] : files) {
        if (path == "-") {
            fmt::print("{}", recorder.text(index));
            continue;
        }
        std::ofstream file(path, std::ios::binary);
        file << recorder.text(index);
        if (!file.flush()) {
            fmt::print(stderr,
                       "{}: cannot be written; is its folder there, and the disk not full?\n",
                       path);
            fine = false;
        }
    }
    return fine;
}

void print_summary(const Engine& engine) {
    for (const Input& input : engine.inputs()) {
        std::uint64_t rejected = 0;
        for (const NamedCount& cause : input.decoder().rejected()) {
            rejected += cause.count;
        }
        fmt::print(stderr, "input {}: {} bytes, {} frames, {} rejected\n", input.name(),
                   input.counts().bytes, input.counts().frames, rejected);
    }
    for (const Output& output : engine.outputs()) {
        fmt::print(stderr, "output {}: {} frames, {} times into failsafe, {} recoveries\n",
                   output.name(), output.counts().sent, output.counts().failsafe_entries,
                   output.counts().recoveries);
    }
}

int simulate(const Options& options) {
    const auto complain = [](const std::string& text, int status) {
        fmt::print(stderr, "{}\n", text);
        return status;
    };
    const auto configuration = load_or_explain(options.config);
    if (!configuration) {
        return kExitWrongUse;
    }
    const auto in = assign_files(options.in, configuration->inputs, "--in");
    if (!in) {
        return complain(in.error(), kExitWrongUse);
    }
    const auto out = assign_files(options.out, configuration->outputs, "--out");
    if (!out) {
        return complain(out.error(), kExitWrongUse);
    }
    const auto tail = parse_duration(options.tail);
    if (!tail) {
        return complain(
            fmt::format("--tail {}: wants a duration such as 2s or 500ms", options.tail),
            kExitWrongUse);
    }
    const auto arrivals = load_arrivals(*in, *configuration);
    if (!arrivals) {
        return complain(arrivals.error(), kExitFailed);
    }
    const auto engine = build_engine(*configuration);
    Recorder recorder(configuration->outputs.size(), options.format);
    play(*engine, recorder, *arrivals, *tail);
    print_summary(*engine);
    return write_outputs(*out, recorder) ? kExitFine : kExitFailed;
}

}  // namespace

void add_simulate_command(CLI::App& app, int& status) {
    auto* command =
        app.add_subcommand("simulate", "Run a configuration over recorded inputs, in virtual time");
    auto options = std::make_shared<Options>();
    command->add_option("CONFIG", options->config, "Configuration file")->required();
    command->add_option("--in", options->in, "NAME=FILE: recorded bytes of an input (repeatable)")
        ->type_name("NAME=FILE");
    command
        ->add_option("--out", options->out,
                     "NAME=FILE: where to put what an output writes, - for standard output "
                     "(repeatable)")
        ->type_name("NAME=FILE");
    command->add_option("--format", options->format, "Form of the outputs")
        ->check(CLI::IsMember({"timed", "hex", "binary"}))
        ->capture_default_str();
    command->add_option("--tail", options->tail, "How long to go on after the last input byte")
        ->capture_default_str();
    command->footer("An input without --in stays silent. Nothing is opened but these files.");
    command->callback([options, &status] { status = simulate(*options); });
}

}  // namespace tribus
