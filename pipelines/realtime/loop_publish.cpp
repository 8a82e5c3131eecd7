#include <algorithm>
#include <cstddef>
#include <span>

#include "pipelines/realtime/loop.h"

namespace tribus {
namespace {

/// Period of publication: half of the period in which the main thread reads.
constexpr Duration kPublishPeriod = std::chrono::milliseconds(100);

/// Whether its frame faults say something.
bool has_faults(const InputFigures& input) {
    return input.implausible_frames > 0 || input.state.cause == LinkCause::garbled ||
           input.state.cause == LinkCause::radio_lost;
}

bool waits(const OutputFigures& output) {
    return output.state.stage == OutputStage::failsafe ||
           output.state.stage == OutputStage::holding;
}

}  // namespace

void Loop::publish_input(std::size_t index, Instant now) {
    engine_.look(index, now);
    const Input& input = engine_.inputs()[index];
    InputFigures status;
    status.at = now;
    status.latest = input.latest();
    status.counts = input.counts();
    const std::span<const NamedCount> causes = input.decoder().rejected();
    for (std::size_t cause = 0; cause < causes.size(); ++cause) {
        status.rejected += causes[cause].count;
        status.rejected_by[std::min(cause, kMostRejectCauses - 1)] = causes[cause].count;
    }
    status.skipped_bytes = input.decoder().skipped_bytes();
    status.interval = input.arrivals().interval();
    status.state = engine_.tell_input(index, now);
    status.implausible_frames = input.link().implausible().frames;
    status.ever_good = input.link().ever_good();
    status.two_senders = input.decoder().two_senders();
    // Before the figures that say that there are some.
    if (has_faults(status)) {
        frame_faults_[index].publish({input.link().implausible(), input.fault()});
    }
    input_figures_[index].publish(status);
}

void Loop::publish_output(std::size_t index, Instant now) {
    Output& output = engine_.output(index);
    OutputFigures status;
    status.at = now;
    status.latest = output.latest();
    status.counts = output.counts();
    status.overruns = output.overruns();
    status.state = engine_.tell_output(index, now);
    status.stage_since = output.look_at_stage(now);
    status.due = output.due();
    status.period = output.period();
    status.sends = output.sends();
    status.answers = output.answers();
    // Before the figures that say that it waits.
    if (waits(status)) {
        output_waits_[index].publish(engine_.wait(index, now));
    }
    output_figures_[index].publish(status);
}

void Loop::publish_values() {
    if (settings_.values == nullptr) {
        return;
    }
    const ValueBoard& board = settings_.values->board();
    for (std::size_t value = 0; value < value_status_.size(); ++value) {
        value_status_[value].publish({.number = board.latest(value),
                                      .at = board.at(value),
                                      .ever = board.ever(value),
                                      .available = board.available(value),
                                      .gaps = board.gaps(value)});
    }
    for (std::size_t bus = 0; bus < bus_states_.size(); ++bus) {
        bus_states_[bus].publish(settings_.values->bus_state(bus));
    }
}

InputStatus Loop::input_status(std::size_t input) const {
    InputStatus status{input_figures_[input].read(), {}};
    if (has_faults(status)) {
        static_cast<FrameFaults&>(status) = frame_faults_[input].read();
    }
    const Instant newest{Duration(newest_at_ns_[input].load(std::memory_order_relaxed))};
    status.newest_at = std::max(newest, status.latest.received);
    return status;
}

OutputStatus Loop::output_status(std::size_t output) const {
    OutputStatus status{output_figures_[output].read(), {}};
    if (waits(status)) {
        status.wait = output_waits_[output].read();
    }
    return status;
}

void Loop::publish(Instant now) {
    next_publish_ = now + kPublishPeriod;
    for (std::size_t i = 0; i < input_figures_.size(); ++i) {
        publish_input(i, now);
    }
    for (std::size_t i = 0; i < output_figures_.size(); ++i) {
        publish_output(i, now);
    }
    publish_values();
    for (std::size_t node = 0; node < node_reports_.size(); ++node) {
        node_reports_[node].publish(engine_.node(node).report());
    }
    const bool machine_counts = settings_.values != nullptr && settings_.machine != nullptr;
    for (std::size_t fact = 0; machine_counts && fact < kMachineFactCount; ++fact) {
        settings_.values->set_machine(fact, settings_.machine->number(fact),
                                      settings_.machine->measured_at());
    }
    publish_can_status();
    absence_status_.publish(absence_);
    published_at_ns_.store(now.time_since_epoch().count(), std::memory_order_release);
}

void Loop::publish_standing_port(Instant now) {
    // A byte may come between a wait and a look, so once is no fault.
    constexpr int kUnheardLooks = 2;
    StandingPort standing;
    for (std::size_t port = 0; port < ports_.size(); ++port) {
        const bool unheard = ports_[port].unheard >= kUnheardLooks;
        if (unheard || (ports_[port].link && ports_[port].link->stands(now))) {
            standing = {unheard ? StandingPort::Fault::unheard : StandingPort::Fault::thread, port};
            break;
        }
    }
    standing_port_.publish(standing);
}

void Loop::publish_can_status() {
    for (const std::size_t port : can_ports_) {
        if (ports_[port].link) {
            const CanLinkStatus status = ports_[port].link->as_can()->status();
            ports_[port].can_status.publish(status);
            if (const auto node =
                    first_of(ports_[port].wiring.stations, StationKind::dronecan_node)) {
                engine_.node(*node).set_bus_counters(status.counts.sent, status.counts.received,
                                                     status.counts.error_frames);
            }
        }
    }
}

}  // namespace tribus
