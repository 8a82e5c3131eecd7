#include "app/appliance.h"

#include <utility>

namespace tribus {

Appliance::Appliance(Configuration configuration)
    : configuration_(std::move(configuration)),
      plans_(plan_ports(configuration_)),
      missing_(plans_.size(), false),
      engine_(build_engine(configuration_)) {}

std::vector<std::string> Appliance::open_devices() {
    std::vector<std::string> errors;
    std::vector<PortWiring> wiring;
    std::vector<std::unique_ptr<Link>> links;
    for (const PortPlan& plan : plans_) {
        auto link = open_port(configuration_, plan);
        if (!link) {
            errors.push_back(link.error());
            continue;
        }
        wiring.push_back(plan.wiring);
        links.push_back(std::move(*link));
    }
    if (errors.empty()) {
        loop_ = std::make_unique<Loop>(*engine_, std::move(wiring), std::move(links));
    }
    return errors;
}

tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> Appliance::start(
    Configuration configuration) {
    std::unique_ptr<Appliance> appliance(new Appliance(std::move(configuration)));
    std::vector<std::string> errors = appliance->open_devices();
    if (!errors.empty()) {
        return tl::unexpected(std::move(errors));
    }
    if (auto prepared = appliance->loop_->prepare(); !prepared) {
        return tl::unexpected(std::vector{prepared.error()});
    }
    const RuntimeConfig& runtime = appliance->configuration_.runtime;
    appliance->thread_ = std::make_unique<DataThread>(
        *appliance->loop_, SchedulingSettings{.priority = runtime.priority,
                                              .cpu = runtime.cpu,
                                              .realtime = runtime.realtime != Realtime::off});
    auto missing = appliance->thread_->prepare();
    if (!missing) {
        return tl::unexpected(std::vector{missing.error()});
    }
    if (runtime.realtime == Realtime::require && !missing->empty()) {
        return tl::unexpected(std::move(*missing));
    }
    appliance->missing_realtime_ = std::move(*missing);
    appliance->thread_->run();
    return appliance;
}

std::vector<Appliance::DeviceEvent> Appliance::tend() {
    std::vector<DeviceEvent> events;
    for (std::size_t port = 0; port < plans_.size(); ++port) {
        const std::string& device = plans_[port].config.device;
        if (loop_->take_lost(port)) {
            missing_[port] = true;
            events.push_back({device, false});
        }
        if (missing_[port]) {
            if (auto link = open_port(configuration_, plans_[port])) {
                loop_->give(port, std::move(*link));
                missing_[port] = false;
                events.push_back({device, true});
            }
        }
    }
    return events;
}

void Appliance::end() {
    loop_->request_end();
    thread_->join();
}

}  // namespace tribus
