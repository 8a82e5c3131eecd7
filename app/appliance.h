#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/machine_values.h"
#include "config/build.h"
#include "config/schema.h"
#include "core/time.h"
#include "pipelines/engine.h"
#include "pipelines/realtime/data_thread.h"
#include "pipelines/realtime/gpio_thread.h"
#include "pipelines/realtime/line_exchange.h"
#include "pipelines/realtime/loop.h"
#include "pipelines/realtime/machine_numbers.h"
#include "pipelines/value_engine.h"

namespace tribus {

/// A configuration at work: its engine, its open devices and its data thread. Thread-bound to the
/// main thread.
class Appliance {
  public:
    enum class MissingDevices : std::uint8_t {
        refuse,    ///< each is an error
        wait_for,  ///< as if they had vanished later; `tend` opens them
    };
    /// Opens every device and starts. The error is one line for each thing that is wrong, and
    /// nothing stays open then.
    static tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> start(
        Configuration configuration, MissingDevices missing = MissingDevices::refuse);

    Appliance(const Appliance&) = delete;
    Appliance& operator=(const Appliance&) = delete;

    /// A change of one device, interface or GPIO line: it is gone, or it is back.
    struct DeviceEvent {
        std::string name;  ///< "device /dev/ttyUSB0"
        bool back = false;
    };
    /// Closes devices that vanished and opens those that are back. Call a few times a second.
    std::vector<DeviceEvent> tend();

    /// Every output says its last frames as its failsafe wants; returns when that is done.
    void end();

    const Configuration& configuration() const { return configuration_; }
    /// What real time could not be had, as sentences.
    const std::vector<std::string>& missing_realtime() const { return missing_realtime_; }
    InputStatus input_status(std::size_t input) const { return loop_->input_status(input); }
    /// Indices of the inputs of an output, the preferred first.
    std::span<const std::size_t> inputs_of(std::size_t output) const {
        return engine_->outputs()[output].inputs();
    }
    OutputStatus output_status(std::size_t output) const { return loop_->output_status(output); }
    /// When the data thread told its figures last: some times a second, as long as it goes on.
    Instant published_at() const { return loop_->published_at(); }
    /// Of a sensor bus, by its place in the configuration.
    SensorBusState bus_state(std::size_t bus) const { return loop_->bus_state(bus); }
    /// Of a node of DroneCAN, in the order of `plan_nodes`.
    dronecan::NodeReport node_report(std::size_t node) const { return loop_->node_report(node); }
    /// Another node has asked for a restart, and may.
    bool restart_wanted() const;
    /// Asks the machine what it tells of itself, at most once a second, and not at all where
    /// nobody asks for values.
    void look_at_machine(Instant now);
    /// Devices and interfaces, each once.
    const std::vector<PortPlan>& ports() const { return plans_; }
    /// Of a port that is a CAN interface.
    CanLinkStatus can_status(std::size_t port) const { return loop_->can_status(port); }
    /// An input or output of that port has FD frames.
    bool uses_fd(const PortWiring& wiring) const;

  private:
    explicit Appliance(Configuration configuration);
    std::vector<std::string> open_devices(MissingDevices missing);
    std::vector<std::unique_ptr<HeldLine>> open_lines(MissingDevices missing,
                                                      std::vector<std::string>& errors);
    std::vector<std::string> make_threads(std::vector<PortWiring> wiring,
                                          std::vector<std::unique_ptr<Link>> links,
                                          std::vector<std::unique_ptr<HeldLine>> lines);
    void tend_lines(std::vector<DeviceEvent>& events);

    Configuration configuration_;
    std::vector<PortPlan> plans_;
    std::vector<bool> missing_;
    /// None where nothing needs them; the engine's outputs look into it.
    std::unique_ptr<ValueEngine> values_;
    std::unique_ptr<Engine> engine_;
    MachineWatch machine_watch_;
    MachineNumbers machine_;
    Instant next_machine_look_{};
    /// None where no lines are configured.
    std::unique_ptr<LineExchange> line_exchange_;
    std::unique_ptr<GpioThread> gpio_thread_;
    std::vector<bool> missing_lines_;
    int tends_until_opening_ = 0;
    std::unique_ptr<Loop> loop_;
    std::unique_ptr<DataThread> thread_;
    std::vector<std::string> missing_realtime_;
};

}  // namespace tribus
