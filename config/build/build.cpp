#include "config/build/build.h"

#include <algorithm>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "config/schema/value_catalog.h"
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
    PortPlan& plan = plans.emplace_back(PortPlan{port, {}});
    plan.wiring.byte_time = byte_time_of(port);
    plan.wiring.has_datagrams = port.medium->has_datagrams;
    return plan;
}

template <class Ids>
void append(std::vector<CanIdMatch>& ids, const Ids& more) {
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

}  // namespace

std::unique_ptr<Engine> build_engine(const Configuration& configuration, MachineId machine) {
    std::vector<NodePlan> nodes = plan_nodes(configuration, machine);
    std::vector<InputSettings> inputs;
    for (const InputConfig& input : configuration.inputs) {
        inputs.push_back({.name = input.name,
                          .decoder = input.protocol->make_decoder(input.settings),
                          .byte_time = byte_time_of(input.port),
                          .supervision = input.supervision,
                          .channels = input.channels});
    }
    std::vector<OutputSettings> outputs;
    for (const OutputConfig& output : configuration.outputs) {
        outputs.push_back(
            {.name = output.name,
             .encoder = output.protocol->make_encoder(output.settings),
             .node = output.protocol == &kDroneCanProtocol ? node_on(nodes, output.port.device)
                                                           : std::nullopt,
             .yield_to_foreign_sender = output.foreign_sender == ForeignSender::failsafe,
             .schedule = output.schedule,
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
    for (std::size_t i = 0; i < configuration.inputs.size(); ++i) {
        plan_for(plans, configuration.inputs[i].port).wiring.inputs.push_back(i);
    }
    for (std::size_t i = 0; i < configuration.outputs.size(); ++i) {
        plan_for(plans, configuration.outputs[i].port).wiring.outputs.push_back(i);
    }
    const auto nodes = plan_nodes(configuration, {});
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        plan_for(plans, nodes[i].port).wiring.node = i;
    }
    if (!needs_values(configuration)) {
        return plans;
    }
    for (std::size_t i = 0; i < configuration.sensor_buses.size(); ++i) {
        PortPlan& plan = plan_for(plans, configuration.sensor_buses[i].port);
        plan.wiring.sensor_buses.push_back(i);
        // The port must be read at once, because a request needs its answer in time.
        plan.wiring.byte_time = {};
    }
    std::size_t message = 0;
    for (const ValuesConfig& values : configuration.values) {
        if (const auto* source = std::get_if<ValueMessageConfig>(&values.source)) {
            plan_for(plans, source->port).wiring.value_messages.push_back(message++);
        }
    }
    return plans;
}

LinkUse link_use(const Engine& engine, const ValueEngine* values, const PortPlan& plan) {
    LinkUse use{.line = plan.config.line,
                .wanted = {},
                .sent = {},
                .settings = plan.config.settings,
                .way = plan.config.medium->users != Users::one ? SettingScope::both
                       : plan.wiring.outputs.empty()           ? SettingScope::input
                                                               : SettingScope::output};
    for (const std::size_t input : plan.wiring.inputs) {
        append(use.wanted, engine.inputs()[input].wanted_ids());
        use.fd = use.fd || engine.inputs()[input].uses_fd();
    }
    for (const std::size_t output : plan.wiring.outputs) {
        append(use.sent, engine.outputs()[output].sent_ids());
        use.fd = use.fd || engine.outputs()[output].uses_fd();
    }
    if (plan.wiring.node) {
        append(use.wanted, engine.node(*plan.wiring.node).wanted());
    }
    for (const std::size_t message : plan.wiring.value_messages) {
        append(use.wanted, values->wanted_ids(message));
        use.fd = use.fd || values->uses_fd(message);
    }
    return use;
}

tl::expected<std::unique_ptr<Link>, std::string> open_port(const Configuration& configuration,
                                                           const Engine& engine,
                                                           const ValueEngine* values,
                                                           const PortPlan& plan) {
    auto link = plan.config.medium->open(plan.config.device, link_use(engine, values, plan));
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
