#include <cstddef>

#include "pipelines/realtime/loop.h"

namespace tribus {
namespace {

/// How often the main thread gets fresh figures: twice as often as it looks at them.
constexpr Duration kPublishPeriod = std::chrono::milliseconds(100);

}  // namespace

void Loop::publish(Instant now) {
    if (now < next_publish_) {
        return;
    }
    next_publish_ = now + kPublishPeriod;
    published_at_.store(now, std::memory_order_relaxed);
    for (std::size_t i = 0; i < input_status_.size(); ++i) {
        engine_.look(i, now);
        const Input& input = engine_.inputs()[i];
        InputStatus status;
        status.latest = input.latest();
        status.counts = input.counts();
        for (const NamedCount& cause : input.decoder().rejected()) {
            status.rejected += cause.count;
        }
        status.skipped_bytes = input.decoder().skipped_bytes();
        status.interval = input.arrivals().interval();
        status.state = input.state();
        status.ever_good = input.link().ever_good();
        input_status_[i].publish(status);
    }
    for (std::size_t i = 0; i < output_status_.size(); ++i) {
        const Output& output = engine_.outputs()[i];
        OutputStatus status;
        status.latest = output.latest();
        status.counts = output.counts();
        status.overruns = output.overruns();
        status.state = output.state(now);
        status.due = output.due();
        status.period = output.period();
        output_status_[i].publish(status);
    }
    for (std::size_t bus = 0; bus < bus_states_.size(); ++bus) {
        bus_states_[bus].publish(settings_.values->bus_state(bus));
    }
    for (std::size_t node = 0; node < node_reports_.size(); ++node) {
        node_reports_[node].publish(engine_.node(node).report());
    }
    const bool machine_counts = settings_.values != nullptr && settings_.machine != nullptr;
    for (std::size_t fact = 0; machine_counts && fact < kMachineFactCount; ++fact) {
        settings_.values->set_machine(fact, settings_.machine->number(fact),
                                      settings_.machine->told_at());
    }
    for (const std::size_t port : can_ports_) {
        if (ports_[port].link) {
            const CanLinkStatus status = ports_[port].link->as_can()->status();
            ports_[port].can_status.publish(status);
            if (const auto node = ports_[port].wiring.node) {
                engine_.node(*node).tell_bus(status.counts.sent, status.counts.received,
                                             status.counts.error_frames);
            }
        }
    }
}

}  // namespace tribus
