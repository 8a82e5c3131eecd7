#include <utility>
#include <vector>

#include "app/appliance/appliance.h"
#include "pipelines/realtime/clock.h"

/// The flight recorder of an appliance; it goes on from one configuration to the next.
namespace tribus {

/// Gives each port its ring in `recorder`, and makes that if there is none.
tl::expected<void, std::string> Appliance::make_recorder(std::unique_ptr<FlightRecorder>& recorder,
                                                         DiskPatience patience) {
    if (!configuration_.recorder) {
        return {};
    }
    if (!recorder) {
        auto made = FlightRecorder::make(configuration_, patience);
        if (!made) {
            return tl::unexpected(made.error());
        }
        recorder = std::move(*made);
    }
    for (PortPlan& plan : plans_) {
        plan.wiring.capture = recorder->ring_for(plan, *configuration_.recorder);
    }
    return {};
}

/// Call it once the loop of the appliance before has stopped.
void Appliance::record_ports(FlightRecorder* recorder) {
    if (configuration_.recorder) {
        recorder->record_ports(configuration_, plans_, monotonic_now());
    }
}

std::unique_ptr<FlightRecorder> Appliance::stop(std::unique_ptr<Appliance> running) {
    // The data thread writes into its rings to the end.
    auto recorder = std::move(running->recorder_);
    running.reset();
    return recorder;
}

}  // namespace tribus
