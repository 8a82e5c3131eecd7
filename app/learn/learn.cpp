#include "app/learn/learn.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tl/expected.hpp>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/load_or_explain.h"
#include "app/cli/streams.h"
#include "app/journal/print_error.h"
#include "app/learn/frame_collector.h"
#include "app/learn/learn_live.h"
#include "app/learn/learn_pad.h"
#include "app/learn/learn_step.h"
#include "app/learn/loss_study.h"
#include "app/replay/simulate_inputs.h"
#include "config/language/mistakes.h"
#include "config/schema/notation.h"
#include "core/quotes.h"
#include "transports/codecs/gamepad/gamepad.h"

namespace tribus {
namespace {

struct LearnOptions {
    std::string file_and_name;
    std::string recording;
    std::string off_at;
    std::string back_at;
    std::string format = "text";
};

using Refused = tl::unexpected<std::string>;

tl::expected<std::size_t, std::string> input_named(const Configuration& configuration,
                                                   std::string_view name) {
    std::vector<std::string_view> names;
    for (const InputConfig& input : configuration.inputs) {
        names.push_back(input.name);
    }
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) {
        return Refused(fmt::format("the configuration has no input {}; {}", in_quotes(name),
                                   suggestion(name, names)));
    }
    return static_cast<std::size_t>(found - names.begin());
}

/// When the transmitter was switched, from the options.
tl::expected<LossStudyTimes, std::string> times_of(const LearnOptions& options) {
    const auto time = [](std::string_view option,
                         const std::string& text) -> tl::expected<Instant, std::string> {
        const auto duration = parse_duration(text);
        if (!duration) {
            return Refused(fmt::format("{} {}: must be a time of the recording, such as 12s",
                                       option, in_quotes(text)));
        }
        return Instant(*duration);
    };
    const auto off = time("--off-at", options.off_at);
    const auto back = time("--back-at", options.back_at);
    if (!off || !back) {
        return Refused(!off ? off.error() : back.error());
    }
    if (*off >= *back) {
        return Refused(
            std::string("the transmitter is switched off before it is on again; --off-at must be "
                        "earlier than --back-at"));
    }
    return LossStudyTimes{.off = *off, .back = *back};
}

tl::expected<LearnedFrames, std::string> frames_of_recording(const LearnOptions& options,
                                                             const Configuration& configuration,
                                                             std::size_t input) {
    const auto times = times_of(options);
    if (!times) {
        return Refused(times.error());
    }
    const auto sources = simulated_sources(configuration);
    auto arrivals = Arrivals::open({{input, options.recording}}, sources);
    if (!arrivals) {
        return Refused(arrivals.error());
    }
    for (const std::string& rest : arrivals->rests()) {
        print_error("{}\n", rest);
    }
    FrameCollector collector(configuration.inputs[input]);
    LearnedFrames learned{.frames = {}, .times = *times};
    auto arrival = arrivals->next();
    for (; arrival && *arrival != nullptr && !collector.overflowed(); arrival = arrivals->next()) {
        const Instant at = (*arrival)->at;
        if (const auto* frame = std::get_if<CanFrame>(&(*arrival)->what)) {
            collector.receive(*frame, at);
        } else if (const auto* byte = std::get_if<ArrivedByte>(&(*arrival)->what)) {
            collector.receive(std::span(&byte->value, 1), std::array{byte->damaged}, at);
        }
    }
    if (!arrival) {
        return Refused(arrival.error());
    }
    if (collector.overflowed()) {
        return Refused(fmt::format(
            "{}: more than {} frames; keep the minutes around --off-at and --back-at only",
            options.recording, FrameCollector::kMostFrames));
    }
    learned.frames = collector.take_frames();
    return learned;
}

void print(const LossStudyResult& study, std::string_view file, std::string_view input) {
    for (const std::string& finding : study.findings) {
        tell_person(finding, "- ");
    }
    for (const std::string& advice : study.advice) {
        print_error("\n");
        tell_person(advice);
    }
    print_error("\n");
    if (!study.recognised) {
        tell_person("The loss of this link is not recognised.");
        return;
    }
    if (study.lines.empty()) {
        tell_person("The loss of this link is recognised with this configuration; add nothing.");
        return;
    }
    tell_person(fmt::format(
        "The loss of this link is recognised with these lines in [input.{}] of {}:", input, file));
    print_error("\n");
    for (const std::string& line : study.lines) {
        fmt::print("{}\n", line);
    }
}

/// As the last step of the guide.
void tell(const LossStudyResult& study) {
    std::string text = fmt::format("{}. ", fmt::join(study.findings, "; "));
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
    for (const std::string& advice : study.advice) {
        text += advice + " ";
    }
    text += !study.recognised     ? "The loss of this link is not recognised."
            : study.lines.empty() ? "The loss of this link is recognised with this configuration; "
                                    "add nothing."
                                  : "The loss of this link is recognised with these lines.";
    tell_learn_step("done", text, study.lines);
}

/// Says why nothing was learned, to people or as the last step.
int give_up(const LearnOptions& options, const std::string& why, int status) {
    if (options.format == "json") {
        tell_learn_step("broken", why);
        return status;
    }
    return complain(why, status);
}

/// An input device stands for itself, because a gamepad needs no configuration to be learned. Names
/// below /dev/input may have colons.
bool is_input_device(const std::string& name) {
    std::error_code error;
    return name.starts_with("/dev/input/") || std::filesystem::is_character_file(name, error);
}

LearnGuide guide_of(const LearnOptions& options) {
    return options.format == "json"      ? LearnGuide::json
           : ::isatty(STDIN_FILENO) == 1 ? LearnGuide::terminal
                                         : LearnGuide::alone;
}

int refuse_recording_of_pad(const LearnOptions& options) {
    return give_up(options,
                   "--recording is for the loss of receivers. Of a gamepad learn finds axes and "
                   "buttons, with the gamepad in your hand; leave --recording out",
                   kExitWrongUse);
}

int learn_input_pad(const LearnOptions& options, const std::string& file, const InputConfig& pad) {
    if (!options.recording.empty()) {
        return refuse_recording_of_pad(options);
    }
    return learn_pad({.device = pad.port.device,
                      .grab = pad.port.settings.get_or("grab", true),
                      .place = fmt::format("[input.{}] of {}", pad.name, file)},
                     guide_of(options));
}

int learn(const LearnOptions& options) {
    if (is_input_device(options.file_and_name)) {
        return options.recording.empty()
                   ? learn_pad({.device = options.file_and_name}, guide_of(options))
                   : refuse_recording_of_pad(options);
    }
    const std::size_t colon = options.file_and_name.rfind(':');
    if (colon == std::string::npos) {
        return complain(
            fmt::format("learn {}: must be CONFIG:INPUT, such as servos.toml:receiver, or "
                        "a gamepad below /dev/input",
                        options.file_and_name),
            kExitWrongUse);
    }
    const std::string file = options.file_and_name.substr(0, colon);
    const std::string name = options.file_and_name.substr(colon + 1);
    const auto configuration = load_or_explain(file);
    if (!configuration) {
        return kExitWrongUse;
    }
    const auto input = input_named(*configuration, name);
    if (!input) {
        return give_up(options, input.error(), kExitWrongUse);
    }
    if (configuration->inputs[*input].protocol == &kGamepadProtocol) {
        return learn_input_pad(options, file, configuration->inputs[*input]);
    }
    const bool json = options.format == "json";
    const auto learned = options.recording.empty()
                             ? watch_with_a_person(*configuration, *input,
                                                   json ? LearnGuide::json : LearnGuide::terminal)
                             : frames_of_recording(options, *configuration, *input);
    if (!learned) {
        return give_up(options, learned.error(), kExitFailed);
    }
    const LossStudyResult study =
        study_loss(configuration->inputs[*input], learned->frames, learned->times);
    json ? tell(study) : print(study, file, name);
    return study.recognised ? kExitFine : kExitFailed;
}

}  // namespace

Command learn_command() {
    auto options = std::make_shared<LearnOptions>();
    return {
        .name = "learn",
        .help = "Learn how a receiver shows the loss of its link, or a gamepad's axes",
        .notes =
            "Of a receiver: guides you through moving the sticks, letting go, switching the "
            "transmitter off and on again, and prints the lines that recognise this receiver's "
            "loss, or what to set on the transmitter. Take the propellers off first. Of a gamepad: "
            "asks for one stick or button after the other, and prints the lines of its input; "
            "without a terminal, too.",
        // Newer versions of CLI11 do not allow a colon in a name.
        .options = {{.name = "INPUT",
                     .value = &options->file_and_name,
                     .help =
                         "An input of a configuration: CONFIG:INPUT, such as servos.toml:receiver; "
                         "or a gamepad: /dev/input/by-id/...-event-joystick",
                     .required = true},
                    {.name = "--recording",
                     .value = &options->recording,
                     .help = "Study recorded bytes instead of the live device",
                     .value_name = "FILE",
                     .needs = {"--off-at", "--back-at"}},
                    {.name = "--off-at",
                     .value = &options->off_at,
                     .help = "When the transmitter was switched off in the recording",
                     .value_name = "DURATION",
                     .needs = {"--recording"}},
                    {.name = "--back-at",
                     .value = &options->back_at,
                     .help = "When it was switched on again, or the recording ends",
                     .value_name = "DURATION",
                     .needs = {"--recording"}},
                    {.name = "--format",
                     .value = &options->format,
                     .help = "json: each step in a line, for a program that guides the person",
                     .shows_value = true,
                     .choices = {"text", "json"}}},
        .examples = {{"tribus learn rc.toml:receiver", "leads you through switching off and on"},
                     {"tribus learn rc.toml:receiver --recording loss.txt --off-at 5s --back-at 8s",
                      "the same from a recording"},
                     {"tribus learn /dev/input/event5", "the sticks and buttons of a gamepad"}},
        .exits = {{kExitFine, "recognised, or the lines are printed"},
                  {kExitFailed, "not recognised, or the work failed"},
                  {kExitInterrupted, "interrupted"}},
        .run = [options] { return learn(*options); },
    };
}

}  // namespace tribus
