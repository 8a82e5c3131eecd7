#include "app/appliance.h"

#include <algorithm>
#include <utility>

namespace tribus {

Appliance::Appliance(Configuration configuration)
    : configuration_(std::move(configuration)),
      plans_(plan_ports(configuration_)),
      missing_(plans_.size(), false),
      engine_(build_engine(configuration_)) {}

std::vector<std::string> Appliance::open_devices(MissingDevices missing) {
    std::vector<std::string> errors;
    std::vector<PortWiring> wiring;
    std::vector<std::unique_ptr<Link>> links;
    for (std::size_t port = 0; port < plans_.size(); ++port) {
        auto link = open_port(configuration_, *engine_, plans_[port]);
        missing_[port] = !link;
        if (!link && missing == MissingDevices::refuse) {
            errors.push_back(link.error());
        }
        wiring.push_back(plans_[port].wiring);
        links.push_back(link ? std::move(*link) : nullptr);
    }
    if (errors.empty()) {
        loop_ = std::make_unique<Loop>(*engine_, std::move(wiring), std::move(links),
                                       LoopSettings{.spin = configuration_.runtime.spin});
    }
    return errors;
}

tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> Appliance::start(
    Configuration configuration, MissingDevices missing) {
    std::unique_ptr<Appliance> appliance(new Appliance(std::move(configuration)));
    std::vector<std::string> errors = appliance->open_devices(missing);
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
    auto missing_realtime = appliance->thread_->prepare();
    if (!missing_realtime) {
        return tl::unexpected(std::vector{missing_realtime.error()});
    }
    if (runtime.realtime == Realtime::require && !missing_realtime->empty()) {
        return tl::unexpected(std::move(*missing_realtime));
    }
    appliance->missing_realtime_ = std::move(*missing_realtime);
    appliance->thread_->run();
    return appliance;
}

std::vector<Appliance::DeviceEvent> Appliance::tend() {
    std::vector<DeviceEvent> events;
    for (std::size_t port = 0; port < plans_.size(); ++port) {
        const PortConfig& config = plans_[port].config;
        if (loop_->take_lost(port)) {
            missing_[port] = true;
            events.push_back({&config, false});
        }
        if (missing_[port]) {
            if (auto link = open_port(configuration_, *engine_, plans_[port])) {
                loop_->give(port, std::move(*link));
                missing_[port] = false;
                events.push_back({&config, true});
            }
        }
    }
    return events;
}

bool Appliance::uses_fd(const PortWiring& wiring) const {
    const auto fd_input = [this](std::size_t i) { return engine_->inputs()[i].uses_fd(); };
    const auto fd_output = [this](std::size_t i) { return engine_->outputs()[i].uses_fd(); };
    return std::ranges::any_of(wiring.inputs, fd_input) ||
           std::ranges::any_of(wiring.outputs, fd_output);
}

void Appliance::end() {
    loop_->request_end();
    thread_->join();
}

}  // namespace tribus
