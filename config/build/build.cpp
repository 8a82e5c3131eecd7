#include "config/build/build.h"

#include <algorithm>
#include <span>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "config/schema/value_catalog.h"
#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/thread_notices.h"
#include "transports/codecs/dronecan/dronecan.h"
#include "transports/links/gpio/gpio_line.h"

namespace tribus {
namespace {

Duration byte_time_of(const PortConfig& port) {
    return port.medium->has_line ? port.line.bytes_time(1) : Duration::zero();
}

PortPlan& plan_for(std::vector<PortPlan>& plans, const PortConfig& port) {
    const auto shared = std::find_if(plans.begin(), plans.end(), [&](const PortPlan& plan) {
        return plan.config.medium == port.medium && plan.config.device == port.device;
    });
    if (shared != plans.end()) {
        return *shared;
    }
    PortPlan& plan = plans.emplace_back(PortPlan{port, {}, {}});
    plan.wiring.byte_time = byte_time_of(port);
    plan.wiring.has_datagrams = port.medium->has_datagrams;
    return plan;
}

void append(std::vector<CanIdMatch>& ids, std::span<const CanIdMatch> more) {
    ids.insert(ids.end(), more.begin(), more.end());
}

std::uint32_t outputs_of(const std::vector<ChannelRule>& rules) {
    std::uint32_t channels = 0;
    for (const ChannelRule& rule : rules) {
        channels |= 1U << rule.output;
    }
    return channels;
}

/// The channels that the pipeline's map makes, and those that the maps of its inputs make.
std::uint32_t mapped_channels(const Configuration& configuration, const PipelineConfig& pipeline) {
    std::uint32_t channels = outputs_of(pipeline.channels);
    for (const std::size_t input : pipeline.selection.inputs) {
        channels |= outputs_of(configuration.inputs[input].channels);
    }
    return channels;
}

tl::unexpected<std::string> at_place(const Configuration& configuration, Location where,
                                     const std::string& error) {
    return tl::unexpected(
        fmt::format("{}:{}:{}: {}", configuration.file, where.line, where.column, error));
}

/// Gives the codec of one end of a link with a key what it needs.
template <class Part, class AnyCodec>
void give_freshness(const Part& part, const CodecSources& sources, AnyCodec& codec) {
    const auto link = link_with_key(part);
    if (link && sources.random != nullptr) {
        std::visit([&](const auto& any) { any->use_seed(sources.random()); }, codec);
    }
    if (link && link->epoch && sources.numbers) {
        std::visit([&](const auto& any) { any->use_numbers(*sources.numbers(*link->epoch)); },
                   codec);
    }
}

AnyDecoder make_decoder(const InputConfig& input, const CodecSources& sources) {
    AnyDecoder decoder = input.protocol->make_decoder(input.settings);
    give_freshness(input, sources, decoder);
    if (link_with_key(input) && sources.random != nullptr) {
        std::visit([&](const auto& any) { any->use_random(sources.random); }, decoder);
    }
    auto* const bytes = std::get_if<std::unique_ptr<ByteDecoder>>(&decoder);
    if (sources.clock != nullptr && bytes != nullptr) {
        (*bytes)->use_clock(*sources.clock);
    }
    return decoder;
}

AnyEncoder make_encoder(const OutputConfig& output, const CodecSources& sources) {
    AnyEncoder encoder = output.protocol->make_encoder(output.settings);
    give_freshness(output, sources, encoder);
    if (sources.clock != nullptr) {
        std::visit([&](const auto& any) { any->use_clock(*sources.clock); }, encoder);
    }
    return encoder;
}

}  // namespace

std::unique_ptr<Engine> build_engine(const Configuration& configuration, MachineId machine,
                                     const CodecSources& sources) {
    std::vector<NodePlan> nodes = plan_nodes(configuration, machine);
    std::vector<InputSettings> inputs;
    for (const InputConfig& input : configuration.inputs) {
        inputs.push_back({.name = input.name,
                          .decoder = make_decoder(input, sources),
                          .byte_time = byte_time_of(input.port),
                          .supervision = input.supervision,
                          .channels = input.channels});
    }
    std::vector<OutputSettings> outputs;
    for (const OutputConfig& output : configuration.outputs) {
        outputs.push_back(
            {.name = output.name,
             .encoder = make_encoder(output, sources),
             .node = output.protocol == &kDroneCanProtocol ? node_on(nodes, output.port.device)
                                                           : std::nullopt,
             // Frames of others say nothing of a link with a key, but could stop it.
             .yield_to_foreign_sender =
                 output.foreign_sender == ForeignSender::failsafe && !link_with_key(output),
             .schedule = output.schedule,
             .least_asked_period = frame_time(output),
             .selection = {},
             .channels = {},
             .mapped_channels = 0,
             .failsafe = {}});
    }
    for (const PipelineConfig& pipeline : configuration.pipelines) {
        for (std::size_t i = 0; i < pipeline.outputs.size(); ++i) {
            OutputSettings& output = outputs[pipeline.outputs[i]];
            output.selection = pipeline.selection;
            output.channels = pipeline.channels;
            output.mapped_channels = mapped_channels(configuration, pipeline);
            output.failsafe = pipeline.failsafe[i];
            for (const std::size_t input : pipeline.selection.inputs) {
                Duration& after = inputs[input].supervision.fewer_channels_after;
                after = std::max(after, output.failsafe.recover);
            }
        }
    }
    std::vector<dronecan::NodeSettings> settings;
    settings.reserve(nodes.size());
    for (NodePlan& node : nodes) {
        settings.push_back(std::move(node.settings));
    }
    return std::make_unique<Engine>(std::move(inputs), std::move(outputs),
                                    line_tasks(configuration), std::move(settings));
}

std::vector<LineTask> line_tasks(const Configuration& configuration) {
    std::vector<LineTask> tasks;
    for (const LineConfig& line : configuration.lines) {
        tasks.push_back(line.task);
    }
    return tasks;
}

std::vector<PortPlan> plan_ports(const Configuration& configuration) {
    std::vector<PortPlan> plans;
    const auto add = [&](StationKind kind, std::size_t index, const PortConfig& port) -> PortPlan& {
        PortPlan& plan = plan_for(plans, port);
        plan.realtime = configuration.runtime.realtime != Realtime::off;
        plan.wiring.stations.push_back({.kind = kind, .index = index});
        return plan;
    };
    for (std::size_t i = 0; i < configuration.inputs.size(); ++i) {
        const InputConfig& input = configuration.inputs[i];
        add(StationKind::input, i, input.port);
        if (is_answered(input)) {
            add(StationKind::answers, i, input.port).wiring.answers = true;
        }
    }
    for (std::size_t i = 0; i < configuration.outputs.size(); ++i) {
        const OutputConfig& output = configuration.outputs[i];
        PortPlan& plan = add(StationKind::output, i, output.port);
        plan.period = output.port.medium->has_period ? output.schedule.period : Duration{};
        if (is_timed_by_receiver(output) || hears_answers(output) || is_answered(output)) {
            add(StationKind::replies, i, output.port);
        }
    }
    const auto nodes = plan_nodes(configuration, {});
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        add(StationKind::dronecan_node, i, nodes[i].port);
    }
    if (!needs_values(configuration)) {
        return plans;
    }
    for (std::size_t i = 0; i < configuration.sensor_buses.size(); ++i) {
        // The port must be read at once, because a request needs its answer in time.
        add(StationKind::sensor_bus, i, configuration.sensor_buses[i].port).wiring.byte_time = {};
    }
    std::size_t message = 0;
    for (const ValuesConfig& values : configuration.values) {
        if (const auto* source = std::get_if<ValueMessageConfig>(&values.source)) {
            add(StationKind::value_message, message++, source->port);
        }
    }
    return plans;
}

LinkUse link_use(const Stations& stations, const PortPlan& plan) {
    LinkUse use{
        .line = plan.config.line,
        .wanted = {},
        .sent = {},
        .settings = plan.config.settings,
        .way = plan.config.medium->users != Users::one               ? SettingScope::both
               : first_of(plan.wiring.stations, StationKind::output) ? SettingScope::output
                                                                     : SettingScope::input,
        .period = plan.period,
        .worker = {.now = monotonic_now, .realtime = plan.realtime, .warn = add_thread_notice}};
    for (const Station& station : plan.wiring.stations) {
        append(use.wanted, stations.wanted_ids(station));
        append(use.sent, stations.sent_ids(station));
        use.fd = use.fd || stations.uses_fd(station);
    }
    return use;
}

tl::expected<std::unique_ptr<Link>, std::string> open_port(const Configuration& configuration,
                                                           const Stations& stations,
                                                           const PortPlan& plan) {
    auto link = plan.config.medium->open(plan.config.device, link_use(stations, plan));
    if (!link) {
        return at_place(configuration, plan.config.where, link.error());
    }
    return link;
}

tl::expected<std::unique_ptr<HeldLine>, std::string> open_line(const Configuration& configuration,
                                                               const LineConfig& line) {
    auto held = std::make_unique<HeldLine>();
    if (is_input_role(line.task.role)) {
        auto input = GpioInput::open(line.place, line.active_low, line.bias);
        if (!input) {
            return at_place(configuration, line.where, input.error());
        }
        held->input = std::move(*input);
        return held;
    }
    const bool active_at_start =
        line.task.role == LineRole::failsafe || line.task.role == LineRole::inverter;
    auto output = GpioOutput::open(line.place, line.active_low, active_at_start);
    if (!output) {
        return at_place(configuration, line.where, output.error());
    }
    held->output = std::move(*output);
    return held;
}

}  // namespace tribus
