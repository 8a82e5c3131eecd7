#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/appliance/bus_off_watch.h"
#include "app/appliance/machine_values.h"
#include "app/epoch/epoch_file.h"
#include "app/recorder/flight_recorder.h"
#include "config/build/build.h"
#include "config/build/carry_over.h"
#include "config/schema/schema.h"
#include "core/time.h"
#include "pipelines/engine/engine.h"
#include "pipelines/realtime/data_thread.h"
#include "pipelines/realtime/gpio_thread.h"
#include "pipelines/realtime/line_exchange.h"
#include "pipelines/realtime/loop.h"
#include "pipelines/realtime/machine_numbers.h"
#include "pipelines/values/value_engine.h"

namespace tribus {

/// A running configuration: its engine, its open devices and its data thread. Thread-bound to the
/// main thread, unless a function says otherwise.
class Appliance {
  public:
    /// Policy for devices that cannot be opened at the start. `reopen_devices` opens those
    /// that the appliance waits for.
    enum class MissingDevices : std::uint8_t {
        refuse,           ///< each one is an error
        wait_for_absent,  ///< waits for ports whose device does not exist; others are errors
        wait_for,         ///< waits for each one, whatever its failure
    };
    /// Builds the engine of a configuration; opens no device. Any thread.
    static std::unique_ptr<Appliance> build(Configuration configuration);
    /// Opens every device and starts the data thread. The error has one line for each failure; then
    /// no device stays open.
    static tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> start(
        std::unique_ptr<Appliance> built, MissingDevices missing = MissingDevices::refuse);
    static tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> start(
        Configuration configuration, MissingDevices missing = MissingDevices::refuse);
    /// The same for a configuration that this program has written. The error is a sentence.
    static tl::expected<std::unique_ptr<Appliance>, std::string> start_text(
        const std::string& text, const std::string& name);
    /// The same after another appliance, whose `recorder` may be there: if the configuration has
    /// one, it goes on. Does not wait for its disk.
    static tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> start(
        std::unique_ptr<Appliance> built, MissingDevices missing,
        std::unique_ptr<FlightRecorder>& recorder);
    /// Ends an appliance without its recorder, which it returns; null if it has none. Waits for no
    /// disk.
    static std::unique_ptr<FlightRecorder> stop(std::unique_ptr<Appliance> running);

    /// Opens files of which it uses numbers, and waits for their disk. `start` and `succeed` do
    /// that too, if it was not done before. Any thread.
    void open_files();
    /// While somebody holds them, they stay open.
    std::vector<std::shared_ptr<EpochFile>> epoch_files() const;

    /// Replaces the running appliance by `next` between two frames. `next` comes from `build`.
    /// Everything new is made and opened first; if that fails, `running` goes on unchanged, and the
    /// error has one line for each failure. On success `running` is null. `recorder` is one that is
    /// left over from a configuration before: `next` takes it, or leaves that of `running` there.
    /// Waits for no disk, if `open_files` was called. Needs a `carry_over` of
    /// the two configurations that has no obstacles. `reopen_devices` opens serial devices that are
    /// missing already or get other line settings.
    static tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> succeed(
        std::unique_ptr<Appliance>& running, std::unique_ptr<Appliance> next,
        const CarryOver& carry_over, std::unique_ptr<FlightRecorder>& recorder);

    Appliance(const Appliance&) = delete;
    Appliance& operator=(const Appliance&) = delete;

    /// A change of one device, interface or GPIO line: it is gone or back.
    struct DeviceEvent {
        std::string_view kind{};  ///< "device", "interface", ..., "line"
        std::string name{};       ///< "/dev/ttyUSB0"
        bool back = false;
        /// Why a device that is there cannot be opened; told once. Empty: nothing new.
        std::string problem{};
    };
    /// The present state of each, as events.
    std::vector<DeviceEvent> devices() const;
    /// Closes devices that vanished and opens those that are back. Call it a few times a second.
    std::vector<DeviceEvent> reopen_devices();
    /// Changes of devices and restarts of CAN interfaces.
    struct DeviceNews {
        std::vector<DeviceEvent> events;
        std::vector<BusOffWatch::Restart> restarts{};
    };
    /// The same, and restarts CAN interfaces after bus-off where the kernel does not.
    DeviceNews look_after_devices(Instant now);

    /// Each output sends its last frames as its failsafe demands; returns when that is done.
    void end();

    const Configuration& configuration() const { return configuration_; }
    /// Missing prerequisites of real time, in sentences.
    const std::vector<std::string>& missing_realtime() const { return missing_realtime_; }
    /// Devices that did not exist at the start and are waited for, in sentences. Only with
    /// `wait_for_absent`.
    const std::vector<std::string>& waits_for() const { return waits_for_; }
    /// Why the data thread has ended by itself, as a sentence. Empty: it runs.
    std::string data_thread_failure() const { return thread_->failure(); }
    bool data_thread_failed() const { return thread_->failed(); }
    /// When the data thread last published its figures.
    Instant figures_at() const { return loop_->published_at(); }
    /// A port that does not do its part though the data thread runs.
    StandingPort standing_port() const { return loop_->standing_port(); }
    /// Whether the thread of the GPIO lines stands though the kernel does not keep it.
    bool gpio_thread_stands(Instant now) const {
        return gpio_thread_ && line_exchange_->hangs(now) && !gpio_thread_->kept_by_kernel();
    }
    /// Periods in which this program did not run.
    AbsenceStatus absence() const { return loop_->absence(); }
    /// Changes of state of inputs and outputs since the start of the data thread. Up to the number
    /// `changes_before` the indices are those of the appliance before.
    const ChangeRing& changes() const { return loop_->changes(); }
    std::uint64_t changes_before() const { return loop_->changes_before(); }
    /// Status and timing of an input or output, by its index, as last published.
    InputStatus input_status(std::size_t input) const { return loop_->input_status(input); }
    const InputTiming& input_timing(std::size_t input) const { return loop_->input_timing(input); }
    /// Name of a cause that `InputStatus::rejected_by` counts.
    std::string_view reject_cause(std::size_t input, std::size_t cause) const;
    /// Number of causes for which `reject_cause` has a name.
    std::size_t reject_cause_count(std::size_t input) const;
    /// Indices of the inputs of an output, in order of preference.
    std::span<const std::size_t> inputs_of(std::size_t output) const {
        return engine_->outputs()[output].inputs();
    }
    OutputStatus output_status(std::size_t output) const { return loop_->output_status(output); }
    const OutputTiming& output_timing(std::size_t output) const {
        return loop_->output_timing(output);
    }
    /// Named values, by their index; none if nothing uses values.
    std::size_t value_count() const { return loop_->value_count(); }
    const NamedValue& value(std::size_t value) const { return values_->board().value(value); }
    ValueStatus value_status(std::size_t value) const { return loop_->value_status(value); }
    /// State of a sensor bus, by its index in the configuration.
    SensorBusState bus_state(std::size_t bus) const { return loop_->bus_state(bus); }
    /// Report of a DroneCAN node, in the order of `plan_nodes`.
    dronecan::NodeReport node_report(std::size_t node) const { return loop_->node_report(node); }
    /// True if another node asked for a restart and is allowed to.
    bool restart_wanted() const;
    /// Follows the system clock. Reads temperature, load and the like of this machine, at most once
    /// a second, and only if values are configured or `watches` says that somebody reads the
    /// result.
    void look_at_machine(Instant now, bool watches = false);
    /// Result of `look_at_machine`; empty if it never read anything.
    const MachineNumbers& machine() const { return machine_; }
    /// Logs if epoch files cannot be written. Call it a few times a second.
    void look_at_epochs();
    /// Null without [recorder] in the configuration.
    FlightRecorder* recorder() const { return recorder_.get(); }
    /// Devices and interfaces, each once.
    const std::vector<PortPlan>& ports() const { return plans_; }
    /// True if the device of this port is open.
    bool port_present(std::size_t port) const { return !missing_[port]; }
    /// True if this GPIO line is open, and an input line can be read.
    bool line_present(std::size_t line) const;
    /// Whether this GPIO line is active. Nothing if it cannot be read, blinks, or carries a wave.
    std::optional<bool> line_active(std::size_t line) const;
    /// Only for a port that is a CAN interface.
    CanLinkStatus can_status(std::size_t port) const { return loop_->can_status(port); }
    /// True if an input, output or value message of that port uses FD frames.
    bool uses_fd(const PortWiring& wiring) const;

  private:
    explicit Appliance(Configuration configuration);
    Stations stations() const { return {*engine_, values_.get()}; }
    std::vector<std::string> open_devices(MissingDevices missing);
    std::unique_ptr<Link> open_or_wait(std::size_t port, MissingDevices missing,
                                       std::vector<std::string>& errors);
    std::vector<std::unique_ptr<HeldLine>> open_lines(MissingDevices missing,
                                                      std::vector<std::string>& errors);
    std::vector<std::string> make_threads(std::vector<PortWiring> wiring,
                                          std::vector<std::unique_ptr<Link>> links,
                                          std::vector<std::unique_ptr<HeldLine>> lines);
    static tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> start(
        std::unique_ptr<Appliance> built, MissingDevices missing,
        std::unique_ptr<FlightRecorder>& recorder, DiskPatience patience);
    tl::expected<void, std::string> make_recorder(std::unique_ptr<FlightRecorder>& recorder,
                                                  DiskPatience patience);
    void record_ports(FlightRecorder* recorder);
    void tell_problem(std::size_t port, const std::string& problem,
                      std::vector<DeviceEvent>& events);
    void reopen_lines(std::vector<DeviceEvent>& events);
    void look_whether_lines_hang(std::vector<DeviceEvent>& events);
    /// After a stop of the whole program one look may come before the lines were read again.
    static constexpr int kSilentLooks = 2;
    bool lines_hang() const { return silent_looks_ == kSilentLooks; }
    LoopSettings loop_settings(LineExchange* lines);
    PortCarry carry_port(const PortPlan& plan, const Appliance& before) const;
    bool same_use(const PortPlan& plan, const Appliance& before, const PortPlan& plan_before) const;
    std::vector<std::string> open_beside(const Appliance& before, std::vector<PortCarry>& ports,
                                         std::vector<std::unique_ptr<Link>>& links);
    void retire_parts(const Leaving& leaving);

    /// A file of `epoch`, and the end of a link whose numbers it keeps.
    struct Epoch {
        std::shared_ptr<EpochFile> file;
        SettingScope way{};
        std::string place;  ///< `file:line:column: [output.NAME]`
    };
    static std::vector<Epoch> epochs_of(const Configuration& configuration);

    Configuration configuration_;
    /// Declared before `engine_`, which uses their numbers.
    std::vector<Epoch> epochs_;
    bool files_opened_ = false;
    std::vector<std::string> file_errors_;
    std::vector<PortPlan> plans_;
    std::vector<bool> missing_;
    /// Why a device that is there could not be opened.
    struct OpenProblem {
        std::string text{};
        bool told = false;
        /// Opening a port may take long, such as one that is measured: then it is tried less often.
        Instant try_at{};
    };
    std::vector<OpenProblem> open_problems_;  ///< one a port
    BusOffWatch bus_off_watch_;
    /// Null if nothing uses values. The outputs of the engine refer to it.
    std::unique_ptr<ValueEngine> values_;
    std::unique_ptr<Engine> engine_;
    /// Declared before `loop_`, which writes into its rings.
    std::unique_ptr<FlightRecorder> recorder_;
    MachineWatch machine_watch_;
    MachineNumbers machine_;
    Instant next_machine_look_{};
    /// Null if no lines are configured.
    std::unique_ptr<LineExchange> line_exchange_;
    std::unique_ptr<GpioThread> gpio_thread_;
    std::vector<bool> missing_lines_;
    /// How many looks in a row found that nobody had read the lines for long.
    int silent_looks_ = 0;
    int calls_until_opening_ = 0;
    std::unique_ptr<Loop> loop_;
    std::unique_ptr<DataThread> thread_;
    std::vector<std::string> missing_realtime_;
    std::vector<std::string> waits_for_;
};

}  // namespace tribus
