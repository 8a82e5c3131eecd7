#include "config/check/cross_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include "config/check/can.h"
#include "config/check/dronecan.h"
#include "config/check/lines.h"
#include "config/check/links.h"
#include "config/check/pairs.h"
#include "config/check/ports.h"
#include "config/check/values.h"
#include "config/schema/notation.h"
#include "core/quotes.h"

namespace tribus {
namespace {

constexpr std::string_view kBus = "sensor_bus";
constexpr std::string_view kValues = "values";

struct PortUse {
    std::string_view direction;
    std::string_view name;
    const PortConfig* port = nullptr;
    bool is_receiver_role = false;
    /// An output of channels that reads what comes back on its line.
    bool hears_replies = false;

    /// Whether both may share a device if their line settings agree: one receives and the other
    /// sends. A sensor answers in the pauses of a receiver that sends servo frames on the same wire
    /// (docs/protocols/ibus.md, "Variants").
    bool goes_with(const PortUse& other) const {
        const auto pair = [&](std::string_view a, std::string_view b) {
            return (direction == a && other.direction == b) ||
                   (direction == b && other.direction == a);
        };
        return (pair("input", "output") && !hears_replies && !other.hears_replies) ||
               pair(kValues, "output") ||
               (pair("input", kBus) && !is_receiver_role && !other.is_receiver_role);
    }
};

std::string line_text(const LineSettings& line) {
    return fmt::format("{} baud 8{}{}", line.baud, line.parity == Parity::even ? 'E' : 'N',
                       line.stop_bits);
}

std::vector<PortUse> port_uses(const Draft& draft) {
    std::vector<PortUse> uses;
    for (const InputDraft& input : draft.inputs) {
        if (input.port_sound) {
            uses.push_back({"input", input.config.name, &input.config.port});
        }
    }
    for (const OutputDraft& output : draft.outputs) {
        if (output.port_sound) {
            uses.push_back(
                {.direction = "output",
                 .name = output.config.name,
                 .port = &output.config.port,
                 .hears_replies = output.needs_pipeline && is_timed_by_receiver(output.config)});
        }
    }
    for (const SensorBusDraft& bus : draft.sensor_buses) {
        if (bus.port_sound) {
            uses.push_back(
                {kBus, bus.config.name, &bus.config.port, bus.config.role == BusRole::receiver});
        }
    }
    for (const ValuesDraft& values : draft.values) {
        const auto* message = std::get_if<ValueMessageConfig>(&values.config.source);
        if (message != nullptr && values.sound) {
            uses.push_back({kValues, values.config.name, &message->port});
        }
    }
    return uses;
}

/// `earlier` stands before `later` in the file.
void check_pair(const PortUse& earlier, const PortUse& later, Mistakes& mistakes) {
    const Medium& medium = *later.port->medium;
    const std::string already = fmt::format(
        "{} {} is already used by [{}.{}] in line {}", medium.place.key,
        in_quotes(later.port->device), earlier.direction, earlier.name, earlier.port->where.line);
    if (medium.users == Users::one) {
        const bool both_ways = earlier.direction != later.direction;
        mistakes.add(later.port->where,
                     fmt::format("{}; one {} serves one input or one output{}", already,
                                 medium.place.key, both_ways ? medium.why_one_way : ""));
        return;
    }
    if (earlier.hears_replies || later.hears_replies) {
        if (!earlier.goes_with(later)) {
            mistakes.add(later.port->where,
                         fmt::format("{}; an output of this kind reads the replies on its device "
                                     "itself, so it shares the device with [values.NAME] at most",
                                     already));
            return;
        }
    }
    const bool bus = earlier.direction == kBus || later.direction == kBus;
    const bool values = earlier.direction == kValues || later.direction == kValues;
    if (!earlier.goes_with(later)) {
        mistakes.add(
            later.port->where,
            fmt::format("{}; one device serves at most one input and one output{}", already,
                        bus      ? ", or one input and one sensor bus with role \"sensor\""
                        : values ? ", or one [values.NAME] and one output"
                                 : ""));
    } else if (earlier.port->line != later.port->line) {
        mistakes.add(
            later.port->where,
            fmt::format("{} with {}, here with {}; {} and {} may share a "
                        "device if their line settings agree",
                        already, line_text(earlier.port->line), line_text(later.port->line),
                        values ? "values" : "an input", bus ? "a sensor bus" : "an output"));
    }
}

void check_devices(const Draft& draft, Mistakes& mistakes) {
    for_each_pair(
        port_uses(draft), [](const PortUse& use) { return use.port->where.line; },
        [&](const PortUse& earlier, const PortUse& later) {
            const PortConfig& port = *earlier.port;
            // A path is one device, in whatever way it is used.
            const bool same = port.medium == later.port->medium || port.device.starts_with("/dev/");
            if (port.medium->users != Users::many && same && port.device == later.port->device) {
                check_pair(earlier, later, mistakes);
            }
        });
}

/// A configuration with values only works without a pipeline.
bool carries_values(const Draft& draft) {
    return !draft.sensor_buses.empty() ||
           std::ranges::any_of(draft.outputs,
                               [](const OutputDraft& output) { return !output.needs_pipeline; });
}

void check_unused(const Draft& draft, Reading reading) {
    for (const InputDraft& input : draft.inputs) {
        const std::string& name = input.config.name;
        if (!input.used && !draft.inputs_uncertain && !reading.lost.mentions(name)) {
            reading.mistakes.add(
                input.where, fmt::format("input {} feeds no pipeline, so it would have no effect; "
                                         "name it in the \"from\" of a pipeline, or leave it out",
                                         in_quotes(name)));
        }
    }
    for (const OutputDraft& output : draft.outputs) {
        const std::string& name = output.config.name;
        if (!output.pipeline && output.needs_pipeline && !draft.outputs_uncertain &&
            !reading.lost.mentions(name)) {
            reading.mistakes.add(
                output.where,
                fmt::format("no pipeline feeds output {}, so it would have no effect; name it in "
                            "the \"to\" of a pipeline, or leave it out",
                            in_quotes(name)));
        }
    }
}

/// A frame must not become older than the timeout before the output is due.
void check_timeout(const InputDraft& input, const PipelineConfig& pipeline, const Draft& draft,
                   Mistakes& mistakes) {
    const OutputDraft* slowest = nullptr;
    for (const std::size_t index : pipeline.outputs) {
        const OutputDraft& output = draft.outputs[index];
        if (!output.needs_pipeline) {
            continue;
        }
        if (slowest == nullptr || output.config.schedule.period > slowest->config.schedule.period) {
            slowest = &output;
        }
    }
    if (slowest == nullptr || !slowest->period_sound || !slowest->port_sound ||
        !input.timeout_sound ||
        input.config.supervision.timeout > slowest->config.schedule.period) {
        return;
    }
    mistakes.add(input.timeout.value_or(slowest->period),
                 fmt::format("the timeout of input {} is {}, but output {} sends every {}: each "
                             "frame would be judged too old; allowed: a timeout longer than the "
                             "period",
                             in_quotes(input.config.name),
                             in_quotes(format_duration(input.config.supervision.timeout)),
                             in_quotes(slowest->config.name),
                             in_quotes(format_duration(slowest->config.schedule.period))));
}

/// Applies to protocols that define the period of their frames.
void check_cycle(const InputDraft& input, Mistakes& mistakes) {
    const InputConfig& config = input.config;
    const bool judged = config.protocol != nullptr && config.protocol->own_period != nullptr &&
                        input.settings_sound && input.timeout_sound;
    const auto cycle = judged ? config.protocol->own_period(config.settings) : std::nullopt;
    if (cycle && config.supervision.timeout <= *cycle) {
        mistakes.add(
            input.timeout.value_or(input.where),
            fmt::format("the timeout of input {} is {}{}, but its messages come every {}: each "
                        "pause between two would count as a loss; allowed: a longer timeout; "
                        "recommended: three times as long",
                        in_quotes(config.name),
                        in_quotes(format_duration(config.supervision.timeout)),
                        input.timeout ? "" : " by default", in_quotes(format_duration(*cycle))));
    }
}

}  // namespace

void check_across(const Draft& draft, Reading reading) {
    check_devices(draft, reading.mistakes);
    check_can_ids(draft, reading);
    doubt_ports(draft, reading.warnings);
    check_links(draft, reading.mistakes);
    check_dronecan(draft, reading.mistakes);
    check_values(draft, reading);
    if (draft.pipelines.empty() && !carries_values(draft)) {
        if (!reading.lost.mentions("pipeline")) {
            reading.mistakes.add(
                {1, 1},
                "there is no pipeline, so nothing would happen; a pipeline connects inputs to "
                "outputs: [pipeline.main] with \"from\" and \"to\"");
        }
        return;
    }
    check_unused(draft, reading);
    check_lines(draft, reading);
    for (const InputDraft& input : draft.inputs) {
        check_cycle(input, reading.mistakes);
    }
    for (const PipelineConfig& pipeline : draft.pipelines) {
        for (const std::size_t index : pipeline.selection.inputs) {
            check_timeout(draft.inputs[index], pipeline, draft, reading.mistakes);
        }
    }
}

}  // namespace tribus
