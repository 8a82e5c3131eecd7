#include <cstdint>
#include <utility>
#include <vector>

#include "app/appliance/appliance.h"
#include "pipelines/realtime/clock.h"

/// The flight recorder of an appliance; it goes on from one configuration to the next.
namespace tribus {

/// Gives each port its ring. Uses the recorder of the appliance `before`, if it has one.
tl::expected<void, std::string> Appliance::make_recorder(Appliance* before) {
    if (!configuration_.recorder) {
        return {};
    }
    FlightRecorder* recorder = before != nullptr ? before->recorder() : nullptr;
    if (recorder == nullptr) {
        auto made = FlightRecorder::make(configuration_);
        if (!made) {
            return tl::unexpected(made.error());
        }
        recorder_ = std::move(*made);
        recorder = recorder_.get();
    }
    for (PortPlan& plan : plans_) {
        plan.wiring.capture = recorder->ring_for(plan, *configuration_.recorder);
    }
    return {};
}

/// Call it once the loop of the appliance before has stopped.
void Appliance::update_recorder() {
    if (recorder_) {
        recorder_->record_ports(configuration_, plans_, monotonic_now());
    }
}

void Appliance::look_at_recorder(Instant now) {
    if (!recorder_) {
        return;
    }
    std::vector<std::uint64_t> entries;
    for (std::size_t output = 0; output < configuration_.outputs.size(); ++output) {
        entries.push_back(output_status(output).counts.failsafe_entries);
    }
    recorder_->look(entries, now, wall_time_now());
}

}  // namespace tribus
