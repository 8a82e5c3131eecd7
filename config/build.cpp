#include "config/build.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "transports/links/can_socket.h"
#include "transports/links/serial_port.h"

namespace tribus {
namespace {

/// Nothing where the protocol is of the other kind of link.
template <class Codec>
std::unique_ptr<Codec> make(std::unique_ptr<Codec> (*maker)(const SettingValues&),
                            const SettingValues& settings) {
    return maker == nullptr ? nullptr : maker(settings);
}

PortPlan& plan_for(std::vector<PortPlan>& plans, const PortConfig& port) {
    const auto shared = std::find_if(plans.begin(), plans.end(), [&](const PortPlan& plan) {
        return plan.config.link == port.link && plan.config.device == port.device;
    });
    if (shared != plans.end()) {
        return *shared;
    }
    PortPlan& plan = plans.emplace_back(PortPlan{port, {}});
    if (port.link == LinkKind::serial) {
        plan.wiring.byte_time = port.line.bytes_time(1);
    }
    return plan;
}

template <class Ids>
void append(std::vector<CanIdMatch>& ids, const Ids& more) {
    ids.insert(ids.end(), more.begin(), more.end());
}

tl::expected<std::unique_ptr<Link>, std::string> open_can(const Engine& engine,
                                                          const PortPlan& plan) {
    CanSocketSettings settings;
    for (const std::size_t input : plan.wiring.inputs) {
        append(settings.wanted, engine.inputs()[input].wanted_ids());
        settings.fd = settings.fd || engine.inputs()[input].uses_fd();
    }
    for (const std::size_t output : plan.wiring.outputs) {
        append(settings.sent, engine.outputs()[output].sent_ids());
        settings.fd = settings.fd || engine.outputs()[output].uses_fd();
    }
    auto socket = CanSocket::open(plan.config.device, settings);
    if (!socket) {
        return tl::unexpected(socket.error());
    }
    return std::unique_ptr<Link>(std::move(*socket));
}

tl::expected<std::unique_ptr<Link>, std::string> open_serial(const PortPlan& plan) {
    auto port = SerialPort::open(plan.config.device, plan.config.line);
    if (!port) {
        return tl::unexpected(port.error());
    }
    return std::unique_ptr<Link>(std::move(*port));
}

}  // namespace

std::unique_ptr<Engine> build_engine(const Configuration& configuration) {
    std::vector<InputSettings> inputs;
    for (const InputConfig& input : configuration.inputs) {
        inputs.push_back({.name = input.name,
                          .decoder = make(input.protocol->make_decoder, input.settings),
                          .can_decoder = make(input.protocol->make_can_decoder, input.settings),
                          .timeout = input.timeout,
                          .failsafe_when = input.failsafe_when});
    }
    std::vector<OutputSettings> outputs;
    for (const OutputConfig& output : configuration.outputs) {
        outputs.push_back({.name = output.name,
                           .encoder = make(output.protocol->make_encoder, output.settings),
                           .can_encoder = make(output.protocol->make_can_encoder, output.settings),
                           .yield_to_foreign_sender = output.yield_to_foreign_sender,
                           .schedule = output.schedule,
                           .inputs = {},
                           .channels = {},
                           .failsafe = {}});
    }
    for (const PipelineConfig& pipeline : configuration.pipelines) {
        for (std::size_t i = 0; i < pipeline.outputs.size(); ++i) {
            OutputSettings& output = outputs[pipeline.outputs[i]];
            output.inputs = pipeline.inputs;
            output.channels = pipeline.channels;
            output.failsafe = pipeline.failsafe[i];
        }
    }
    return std::make_unique<Engine>(std::move(inputs), std::move(outputs));
}

std::vector<PortPlan> plan_ports(const Configuration& configuration) {
    std::vector<PortPlan> plans;
    for (std::size_t i = 0; i < configuration.inputs.size(); ++i) {
        plan_for(plans, configuration.inputs[i].port).wiring.inputs.push_back(i);
    }
    for (std::size_t i = 0; i < configuration.outputs.size(); ++i) {
        plan_for(plans, configuration.outputs[i].port).wiring.outputs.push_back(i);
    }
    return plans;
}

tl::expected<std::unique_ptr<Link>, std::string> open_port(const Configuration& configuration,
                                                           const Engine& engine,
                                                           const PortPlan& plan) {
    auto link = plan.config.link == LinkKind::can ? open_can(engine, plan) : open_serial(plan);
    if (!link) {
        return tl::unexpected(fmt::format("{}:{}:{}: {}", configuration.file,
                                          plan.config.where.line, plan.config.where.column,
                                          link.error()));
    }
    return link;
}

}  // namespace tribus
