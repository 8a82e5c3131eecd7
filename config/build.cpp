#include "config/build.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "transports/links/serial_port.h"

namespace tribus {

std::unique_ptr<Engine> build_engine(const Configuration& configuration) {
    std::vector<InputSettings> inputs;
    for (const InputConfig& input : configuration.inputs) {
        inputs.push_back({.name = input.name,
                          .decoder = input.protocol->make_decoder(input.settings),
                          .timeout = input.timeout,
                          .failsafe_when = input.failsafe_when});
    }
    std::vector<OutputSettings> outputs;
    for (const OutputConfig& output : configuration.outputs) {
        outputs.push_back({.name = output.name,
                           .encoder = output.protocol->make_encoder(output.settings),
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
        plans.push_back({configuration.inputs[i].port, {.input = i, .output = std::nullopt}});
    }
    for (std::size_t i = 0; i < configuration.outputs.size(); ++i) {
        const PortConfig& port = configuration.outputs[i].port;
        const auto shared = std::find_if(plans.begin(), plans.end(), [&](const PortPlan& plan) {
            return plan.config.device == port.device;
        });
        if (shared != plans.end()) {
            shared->wiring.output = i;
        } else {
            plans.push_back({port, {.input = std::nullopt, .output = i}});
        }
    }
    return plans;
}

tl::expected<std::unique_ptr<Link>, std::string> open_port(const Configuration& configuration,
                                                           const PortPlan& plan) {
    auto port = SerialPort::open(plan.config.device, plan.config.line);
    if (!port) {
        return tl::unexpected(fmt::format("{}:{}:{}: {}", configuration.file,
                                          plan.config.where.line, plan.config.where.column,
                                          port.error()));
    }
    return std::unique_ptr<Link>(std::move(*port));
}

}  // namespace tribus
