#include "app/init/init.h"

#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/streams.h"
#include "app/init/attachment.h"
#include "app/init/configuration_text.h"
#include "app/init/dialogue.h"
#include "app/init/messages.h"
#include "app/init/next_commands.h"
#include "app/init/options.h"
#include "app/init/ports.h"
#include "app/init/write_file.h"
#include "app/journal/terminal_stream.h"
#include "config/build/machine_mistakes.h"
#include "config/keys/keys.h"
#include "config/load.h"
#include "config/schema/notation.h"

namespace tribus {
namespace init {
namespace {

constexpr std::string_view kStandardOutput = "-";

/// After a place was refused for which no protocol was named: which protocols would be accepted.
void offer_protocols(const PlaceOption& option, SettingScope way, const ExaminedPlace& examined,
                     const Protocol& refused, Messages& messages) {
    if (option.protocol != nullptr || !examined.known) {
        return;
    }
    std::vector<std::string> names;
    for (const Protocol* protocol : offered_protocols(way, *examined.medium)) {
        const bool accepted =
            way == SettingScope::input
                ? decide_input(examined, protocol).attachment.has_value()
                : protocol != &refused && decide_output(examined, protocol, "").attachment;
        if (accepted) {
            names.emplace_back(protocol->name);
        }
    }
    if (!names.empty()) {
        messages.say(
            fmt::format("To write the file nevertheless, name the protocol, {} "
                        "PLACE=PROTOCOL:",
                        option_of(way)));
        messages.side_by_side(names);
    }
}

OrFailure<Attachment> decide(const PlaceOption& option, SettingScope way, Ports& ports,
                             Messages& messages) {
    ExaminedPlace examined = ports.look(option.place);
    const bool fits =
        option.protocol == nullptr || option.protocol->shape == examined.medium->shape;
    const Protocol& usual = usual_protocol(examined.medium->shape);
    std::string trial;
    if (fits && way == SettingScope::input) {
        examined = ports.listen(option.place);
    } else if (fits) {
        trial =
            ports.try_line(examined, (option.protocol != nullptr ? *option.protocol : usual).line);
    }
    Decision decision = way == SettingScope::input
                            ? decide_input(examined, option.protocol)
                            : decide_output(examined, option.protocol, trial);
    const std::string place = fmt::format("{} {}", option_of(way), option.place);
    if (is_wrong_kind(examined, option.protocol)) {
        return failed(fmt::format("{}: {}", place, decision.attachment.error()), kExitWrongUse);
    }
    messages.findings(decision.findings);
    if (!decision.attachment) {
        offer_protocols(option, way, examined, usual, messages);
        return failed(fmt::format("{}: {}", place, decision.attachment.error()));
    }
    for (const std::string& remark : decision.attachment->remarks) {
        messages.say(fmt::format("{}: {}", examined.node, remark));
    }
    if (option.protocol == nullptr && decision.attachment->remarks.empty()) {
        messages.say(fmt::format("{}: {}, because no protocol is named ({} PLACE=PROTOCOL)",
                                 examined.node, decision.attachment->protocol->name,
                                 option_of(way)));
    }
    return *std::move(decision.attachment);
}

/// A device has one name in a configuration, whichever links lead to it.
void add_to(Plan& plan, SettingScope way, Attachment end) {
    for (const auto* others : {&plan.inputs, &plan.outputs}) {
        const auto same = std::ranges::find(*others, end.node, &Attachment::node);
        if (same != others->end()) {
            end.name = same->name;
        }
    }
    (way == SettingScope::input ? plan.inputs : plan.outputs).push_back(std::move(end));
}

/// Adds the inputs or outputs from the command line.
OrFailure<void> add_options(const std::vector<PlaceOption>& options, SettingScope way, Plan& plan,
                            Ports& ports, Messages& messages) {
    for (const PlaceOption& option : options) {
        auto attachment = decide(option, way, ports, messages);
        if (!attachment) {
            return tl::unexpected(attachment.error());
        }
        std::vector<Attachment> others = plan.inputs;
        others.insert(others.end(), plan.outputs.begin(), plan.outputs.end());
        if (const std::string conflict = port_conflict(others, *attachment); !conflict.empty()) {
            return failed(fmt::format("{} {}: {}", option_of(way), option.place, conflict),
                          kExitWrongUse);
        }
        add_to(plan, way, *std::move(attachment));
    }
    return {};
}

/// Asks for what the options leave open. Returns false if the answers end before the questions.
bool ask_rest(const Options& options, Plan& plan, Dialogue& dialogue) {
    if (plan.inputs.empty()) {
        auto input = dialogue.ask_input();
        if (!input) {
            return false;
        }
        add_to(plan, SettingScope::input, *std::move(input));
    }
    if (plan.outputs.empty()) {
        auto output = dialogue.ask_output(plan.inputs);
        if (!output) {
            return false;
        }
        add_to(plan, SettingScope::output, *std::move(output));
    }
    if (!options.throttle && sends_presets(plan)) {
        const auto throttle = dialogue.ask_throttle();
        if (!throttle) {
            return false;
        }
        plan.throttle_us = *throttle;
    }
    return true;
}

OrFailure<Plan> make_plan(const Options& options, const Request& request, Messages& messages) {
    const bool terminal = ::isatty(STDIN_FILENO) == 1;
    const bool watched = terminal || ::isatty(STDERR_FILENO) == 1;
    MachinePorts ports(request.listening, [&](std::string_view progress) {
        if (watched) {
            messages.say(progress);
        }
    });
    Plan plan;
    plan.throttle_us = options.throttle.value_or(kLowThrottleUs);
    auto added = add_options(request.inputs, SettingScope::input, plan, ports, messages);
    if (added) {
        added = add_options(request.outputs, SettingScope::output, plan, ports, messages);
    }
    if (!added) {
        return tl::unexpected(added.error());
    }
    if (!plan.inputs.empty() && !plan.outputs.empty()) {
        return plan;
    }
    messages.say(
        "This writes a configuration. It sends nothing to any port. Ctrl-C ends it and leaves "
        "nothing behind.");
    Dialogue dialogue(std::cin, !terminal, messages, ports);
    if (ask_rest(options, plan, dialogue)) {
        return plan;
    }
    return terminal ? failed("the answers ended before the questions; nothing is written")
                    : failed(
                          "the answers ended before the questions; nothing is written. To be "
                          "asked nothing, give --in PLACE and --out PLACE, such as tribus init "
                          "--in /dev/ttyUSB0 --out /dev/ttyUSB1",
                          kExitWrongUse);
}

/// What `check` would say about this text, one line for each mistake.
std::vector<std::string> mistakes_in(const std::string& text, const std::string& file) {
    const auto configuration = load_configuration(text, file);
    std::vector<std::string> lines;
    for (const Mistake& mistake :
         configuration ? mistaken_devices(*configuration) : configuration.error()) {
        lines.push_back(mistake.text);
    }
    return lines;
}

void tell_next(const std::string& file, const Plan& plan, Messages& messages) {
    const auto commands = [&](const std::vector<std::string>& lines) {
        for (const std::string& line : lines) {
            messages.line("  " + line);
        }
    };
    const std::string preset =
        sends_presets(plan)
            ? fmt::format(
                  "set `preset` in {} to what is safe on your machine (channel 3 gets {} us "
                  "now), then ",
                  file, format_number(plan.throttle_us))
            : std::string();
    messages.say(
        fmt::format("Next, with the propellers off: {}check the file, find out what the "
                    "receiver does without its transmitter, and only then run it:",
                    preset));
    commands(next_commands(file, input_names(plan).front()));
    messages.say("As a service, at every start of the board:");
    commands(service_commands(file));
}

int run_init(const Options& options) {
    const auto request = read_options(options);
    if (!request) {
        return complain(request.error().text, request.error().status);
    }
    const bool to_file = options.file != kStandardOutput;
    const std::string problem = to_file ? file_problem(options.file, options.force) : std::string();
    if (!problem.empty()) {
        return complain(problem, kExitFailed);
    }
    Messages messages(std::cerr, text_columns(STDERR_FILENO), shows_colour(STDERR_FILENO));
    const auto plan = make_plan(options, *request, messages);
    if (!plan) {
        return complain(plan.error().text, plan.error().status);
    }
    const std::string text = configuration_text(*plan, options.file);
    if (const auto mistakes = mistakes_in(text, options.file); !mistakes.empty()) {
        return complain(
            fmt::format("nothing is written, because `tribus check` would refuse it: {}",
                        fmt::join(mistakes, "; ")),
            kExitWrongUse);
    }
    if (!to_file) {
        std::cout << text;
        return kExitFine;
    }
    if (const auto written = write_file(options.file, text, options.force); !written) {
        return complain(written.error(), kExitFailed);
    }
    messages.say(fmt::format("{} is written.", options.file));
    tell_next(options.file, *plan, messages);
    return kExitFine;
}

}  // namespace
}  // namespace init

Command init_command() {
    const auto options = std::make_shared<init::Options>();
    return {
        .name = "init",
        .help = "Write a first configuration: ask what is attached, look, listen",
        .notes =
            "PLACE is a serial device (/dev/ttyUSB0), an SPI port (/dev/spidev0.0) or a CAN "
            "interface (can0). Without a PROTOCOL, a serial input has the one that is heard "
            "there, all else has sbus or can. Without --in or --out it asks. It writes nothing to "
            "a port.",
        .options = {{.name = "FILE",
                     .value = &options->file,
                     .help = "File to write; - prints it",
                     .shows_value = true},
                    {.name = "--in",
                     .value = &options->in,
                     .help = "Where the signal comes from; the preferred one first",
                     .value_name = "PLACE[=PROTOCOL]",
                     .one_each = true},
                    {.name = "--out",
                     .value = &options->out,
                     .help = "Where the signal goes",
                     .value_name = "PLACE[=PROTOCOL]",
                     .one_each = true},
                    {.name = "--listen",
                     .value = &options->listening,
                     .help = "How long to listen to each serial input; 0: open no port",
                     .shows_value = true,
                     .value_name = "DURATION"},
                    {.name = "--throttle",
                     .value = &options->throttle,
                     .help = "Pulse of channel 3 in failsafe",
                     .range = {{kLeastPulse, kMostPulse}},
                     .value_name = "MICROSECONDS",
                     .default_text = format_number(init::kLowThrottleUs)},
                    {.name = "--force",
                     .value = &options->force,
                     .help = "Replace the file if it exists"}},
        .examples = {{"tribus init", "asks, and writes tribus.toml"},
                     {"tribus init --in /dev/ttyAMA5 --out /dev/ttyAMA3=sbus servos.toml",
                      "asks nothing; the protocol of the input is the one that is heard"}},
        .exits = {{kExitFine, "the file is written"},
                  {kExitFailed, "it is not, because of a port, silence or the file"}},
        .run = [options] { return init::run_init(*options); },
    };
}

}  // namespace tribus
