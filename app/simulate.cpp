#include "app/simulate.h"

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
#include <CLI/CLI.hpp>
#include <tl/expected.hpp>

#include "app/exit_status.h"
#include "app/load_or_explain.h"
#include "app/simulate_inputs.h"
#include "config/build.h"
#include "config/mistakes.h"
#include "config/values.h"
#include "core/quotes.h"
#include "pipelines/virtual_loop.h"
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

/// Keeps what each output wrote: CAN frames as a log of candump, bytes in the asked format.
class Recorder final : public OutputObserver {
  public:
    Recorder(const std::vector<OutputConfig>& outputs, std::string_view format)
        : outputs_(outputs), texts_(outputs.size()), format_(format) {
        for (std::size_t output = 0; output < outputs.size(); ++output) {
            if (format_ == "timed" && outputs[output].protocol->link == LinkKind::serial) {
                texts_[output] = kTimedHeading;
            }
        }
    }

    void wrote(std::size_t output, Instant at, const Transmission& sent) override {
        std::string& text = texts_[output];
        for (const CanFrame& frame : sent.can_frames) {
            append_candump_line(text, at.time_since_epoch(), outputs_[output].port.device, frame);
        }
        if (sent.bytes.empty()) {
            return;
        }
        if (format_ == "timed") {
            append_timed_line(text, at.time_since_epoch(), sent.bytes);
        } else if (format_ == "hex") {
            append_hex_line(text, sent.bytes);
        } else {
            text.append(sent.bytes.begin(), sent.bytes.end());
        }
    }
    const std::string& text(std::size_t output) const { return texts_[output]; }

  private:
    const std::vector<OutputConfig>& outputs_;
    std::vector<std::string> texts_;
    std::string format_;
};

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
            return tl::unexpected(fmt::format("{} {}: the configuration has no {}; {}", option,
                                              pair, in_quotes(name), suggestion(name, names)));
        }
        const auto index = static_cast<std::size_t>(found - names.begin());
        if (!files.emplace(index, pair.substr(equals + 1)).second) {
            return tl::unexpected(
                fmt::format("{} {}: {} was given before", option, pair, in_quotes(name)));
        }
    }
    return files;
}

void play(Engine& engine, Recorder& recorder, const Arrivals& arrivals, Duration tail) {
    VirtualLoop loop(engine, recorder, Instant{});
    for (const Arrival& arrival : arrivals.in_order) {
        if (const auto* frame = std::get_if<ArrivedCanFrame>(&arrival.what)) {
            loop.receive(arrival.input, arrivals.can_frames[frame->index], arrival.at);
        } else if (const auto* byte = std::get_if<ArrivedByte>(&arrival.what)) {
            loop.receive(arrival.input, std::span(&byte->value, 1), std::array{byte->damaged},
                         arrival.at);
        }
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
    Recorder recorder(configuration->outputs, options.format);
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
    command
        ->add_option("--in", options->in,
                     "NAME=FILE: recorded bytes of an input, or the log of candump of a CAN "
                     "input (repeatable)")
        ->type_name("NAME=FILE");
    command
        ->add_option("--out", options->out,
                     "NAME=FILE: where to put what an output writes, - for standard output "
                     "(repeatable)")
        ->type_name("NAME=FILE");
    command
        ->add_option("--format", options->format,
                     "Form of the outputs; those of CAN are always logs as of candump")
        ->check(CLI::IsMember({"timed", "hex", "binary"}))
        ->capture_default_str();
    command->add_option("--tail", options->tail, "How long to go on after the last input")
        ->capture_default_str();
    command->footer(
        "An input without --in stays silent. Nothing is opened but these files. Each recording "
        "starts when the simulation does; what several CAN inputs heard at the same time belongs "
        "into one log, with --in for each of them.");
    command->callback([options, &status] { status = simulate(*options); });
}

}  // namespace tribus
