#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/flight_recorder.h"
#include "app/machine_values.h"
#include "config/build.h"
#include "config/carry_over.h"
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
    /// What becomes of devices that cannot be opened. `tend` opens what is waited for, as if it had
    /// vanished later.
    enum class MissingDevices : std::uint8_t {
        refuse,           ///< each is an error
        wait_for_absent,  ///< a port of which there is nothing is waited for; others are errors
        wait_for,         ///< each is waited for, whatever is wrong with it
    };
    /// All that can be made of a configuration beforehand. Opens no device. Any thread.
    static std::unique_ptr<Appliance> build(Configuration configuration);
    /// Opens every device and starts. The error is one line for each thing that is wrong, and
    /// nothing stays open then.
    static tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> start(
        std::unique_ptr<Appliance> built, MissingDevices missing = MissingDevices::refuse);
    static tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> start(
        Configuration configuration, MissingDevices missing = MissingDevices::refuse);

    /// A fresh one, as built, in the place of the running one, between two frames. All that is new
    /// is made and opened beside it first: where that fails, `running` runs on as if nothing had
    /// been asked for, and the error says why, a line for each thing. Afterwards it is gone. Needs
    /// a `carry_over` without obstacles, of the two configurations. A serial device that is to be
    /// used with other line settings, or that is missing already, is left to `tend`.
    static tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> succeed(
        std::unique_ptr<Appliance>& running, std::unique_ptr<Appliance> next,
        const CarryOver& carry_over);

    Appliance(const Appliance&) = delete;
    Appliance& operator=(const Appliance&) = delete;

    /// A change of one device, interface or GPIO line: it is gone, or it is back.
    struct DeviceEvent {
        std::string name;  ///< "device /dev/ttyUSB0"
        bool back = false;
    };
    /// How it stands with each, in the words of an event.
    std::vector<DeviceEvent> devices() const;
    /// Closes devices that vanished and opens those that are back. Call a few times a second.
    std::vector<DeviceEvent> tend();

    /// Every output says its last frames as its failsafe wants; returns when that is done.
    void end();

    const Configuration& configuration() const { return configuration_; }
    /// What real time could not be had, as sentences.
    const std::vector<std::string>& missing_realtime() const { return missing_realtime_; }
    /// What was not there at the start and is waited for, as sentences. Of `wait_for_absent` only.
    const std::vector<std::string>& waits_for() const { return waits_for_; }
    /// When the data thread last wrote down its figures.
    Instant figures_at() const { return loop_->published_at(); }
    AbsenceStatus absence() const { return loop_->absence(); }
    InputStatus input_status(std::size_t input) const { return loop_->input_status(input); }
    const InputTiming& input_timing(std::size_t input) const { return loop_->input_timing(input); }
    /// What `InputStatus::rejected_by` counts.
    std::string_view reject_cause(std::size_t input, std::size_t cause) const;
    std::size_t reject_cause_count(std::size_t input) const;
    /// Indices of the inputs of an output, the preferred first.
    std::span<const std::size_t> inputs_of(std::size_t output) const {
        return engine_->outputs()[output].inputs();
    }
    OutputStatus output_status(std::size_t output) const { return loop_->output_status(output); }
    const OutputTiming& output_timing(std::size_t output) const {
        return loop_->output_timing(output);
    }
    /// Of all named values, by their places; none where nothing needs values.
    std::size_t value_count() const { return loop_->value_count(); }
    const NamedValue& value(std::size_t value) const { return values_->board().value(value); }
    ValueStatus value_status(std::size_t value) const { return loop_->value_status(value); }
    /// Of a sensor bus, by its place in the configuration.
    SensorBusState bus_state(std::size_t bus) const { return loop_->bus_state(bus); }
    /// Of a node of DroneCAN, in the order of `plan_nodes`.
    dronecan::NodeReport node_report(std::size_t node) const { return loop_->node_report(node); }
    /// Another node has asked for a restart, and may.
    bool restart_wanted() const;
    /// Asks the machine what it tells of itself, at most once a second, and not at all where
    /// nobody asks for values, unless somebody `watches`.
    void look_at_machine(Instant now, bool watches = false);
    /// What it told; nothing where nobody asked.
    const MachineNumbers& machine() const { return machine_; }
    /// None where the configuration wants none.
    FlightRecorder* recorder() const { return recorder_.get(); }
    /// Tells the recorder what happened. Call a few times a second.
    void look_at_recorder(Instant now);
    /// Devices and interfaces, each once.
    const std::vector<PortPlan>& ports() const { return plans_; }
    /// Its device is there and open.
    bool port_present(std::size_t port) const { return !missing_[port]; }
    /// Of a GPIO line.
    bool line_present(std::size_t line) const { return !missing_lines_[line]; }
    /// Of a port that is a CAN interface.
    CanLinkStatus can_status(std::size_t port) const { return loop_->can_status(port); }
    /// An input or output of that port has FD frames.
    bool uses_fd(const PortWiring& wiring) const;

  private:
    explicit Appliance(Configuration configuration);
    std::vector<std::string> open_devices(MissingDevices missing);
    std::unique_ptr<Link> open_or_wait(std::size_t port, MissingDevices missing,
                                       std::vector<std::string>& errors);
    std::vector<std::unique_ptr<HeldLine>> open_lines(MissingDevices missing,
                                                      std::vector<std::string>& errors);
    std::vector<std::string> make_threads(std::vector<PortWiring> wiring,
                                          std::vector<std::unique_ptr<Link>> links,
                                          std::vector<std::unique_ptr<HeldLine>> lines);
    tl::expected<void, std::string> make_recorder(Appliance* before);
    void settle_recorder();
    void tend_lines(std::vector<DeviceEvent>& events);
    LoopSettings loop_settings(LineExchange* lines);
    PortCarry carry_port(const PortPlan& plan, const Appliance& before) const;
    bool same_can_use(const PortPlan& plan, const Appliance& before,
                      const PortPlan& plan_before) const;
    std::vector<std::string> open_beside(const Appliance& before, std::vector<PortCarry>& ports,
                                         std::vector<std::unique_ptr<Link>>& links);
    void retire_parts(const Leaving& leaving);

    Configuration configuration_;
    std::vector<PortPlan> plans_;
    std::vector<bool> missing_;
    /// None where nothing needs them; the engine's outputs look into it.
    std::unique_ptr<ValueEngine> values_;
    std::unique_ptr<Engine> engine_;
    /// Its rings outlive the loop.
    std::unique_ptr<FlightRecorder> recorder_;
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
    std::vector<std::string> waits_for_;
};

}  // namespace tribus
