#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/appliance/appliance.h"
#include "app/journal/log_limit.h"
#include "app/log/can_report.h"
#include "app/log/node_log.h"
#include "app/log/sensor_bus_log.h"
#include "app/state_text/cause_text.h"
#include "app/state_text/wait_text.h"
#include "config/build/carry_over.h"
#include "core/change_report.h"
#include "core/rate_limit.h"
#include "core/time.h"

namespace tribus {

/// Logs changes of state; logs nothing while nothing changes. Thread-bound to the main thread.
class StateLog {
  public:
    StateLog(const Appliance& appliance, Instant start);

    /// Logs how each CAN interface is configured.
    void log_interfaces(const Appliance& appliance) { can_.start(appliance); }
    /// After a reload: does not repeat what `before` said about the parts that go on, and still
    /// logs the changes for which its rate limit left no line.
    void go_on_from(const StateLog& before, const Appliance& appliance,
                    const CarryOver& carry_over);

    /// Logs each change since the last call, at most a few lines per time for each input, output
    /// and device. `news`: of the appliance, since the last call.
    void look(const Appliance& appliance, const Appliance::DeviceNews& news, Instant now);

  private:
    struct InputMemory {
        /// Since when something may come.
        Instant start;
        ChangeReport<LinkCause> cause{LinkCause::never_seen};
        bool missing_signal_logged = false;
        bool two_senders_logged = false;
        RateLimit limit = log_limit();
        /// Places of the counters of what a key does not prove, and what they were when told.
        std::vector<std::size_t> unproved_causes{};
        std::uint64_t unproved = 0;
        RateLimit unproved_limit{1, std::chrono::minutes(1)};
        std::uint64_t implausible = 0;
        RateLimit implausible_limit{1, std::chrono::minutes(1)};
    };
    /// Holds names, not indices: another configuration may number the inputs differently.
    struct OutputWord {
        std::string state;
        std::string outvoted;
        /// What it waits for; see `wait_key`.
        std::string awaited;
        bool operator==(const OutputWord&) const = default;
    };
    struct OutputMemory {
        /// As looked at last.
        std::optional<OutputState> state;
        WaitWatch awaited{};
        ChangeReport<OutputWord> word{
            OutputWord{.state = output_text({}, {}), .outvoted = "", .awaited = ""}};
        /// The bits of `OutputState::by_preset` that were logged already.
        std::uint32_t presets_logged = 0;
        std::uint64_t busy_drops = 0;
        std::uint64_t foreign_frames = 0;
        /// Answers that were heard before the output was in control, and what was logged of those
        /// since then.
        Answers before{};
        std::string advice;
        RateLimit limit = log_limit();
        /// Continuous events have their own limits and leave the lines for changes of state.
        RateLimit drops_limit = log_limit();
        RateLimit foreign_limit = log_limit();
    };
    struct DeviceMemory {
        bool present = true;
        bool ever = true;
        ChangeReport<bool> word{true};
        RateLimit limit = log_limit();
    };

    void look_at_absence(const AbsenceStatus& absence, Instant now);
    void look_at_devices(std::span<const Appliance::DeviceEvent> events, Instant now);
    void look_at_input(const std::string& name, const InputStatus& status, InputMemory& memory,
                       Instant now);
    static void look_at_implausible(const std::string& name, const InputStatus& status,
                                    InputMemory& memory, Instant now);
    static void look_at_unproved(const std::string& name, const InputStatus& status,
                                 InputMemory& memory, Instant now);
    void look_at_output(const std::string& name, const OutputStatus& status,
                        std::span<const std::size_t> places, OutputMemory& memory, Instant now);
    std::string outvoted_names(std::uint32_t outvoted, std::span<const std::size_t> places) const;
    void look_at_state(const std::string& name, const OutputStatus& status,
                       std::span<const std::size_t> places, const std::string& awaited,
                       OutputMemory& memory, Instant now);
    void look_at_answers(const OutputConfig& output, const OutputStatus& status,
                         OutputMemory& memory) const;
    void look_at_drops(const std::string& name, const OutputStatus& status, OutputMemory& memory,
                       Instant now);
    static bool knows_the_reason(const InputStatus& status);
    static void log_missing_signal(const std::string& name, const InputStatus& status,
                                   const PortPlan& port, InputMemory& memory, Instant now);

    std::vector<std::string> input_names_;
    std::vector<InputMemory> inputs_;
    std::vector<OutputMemory> outputs_;
    std::map<std::string, DeviceMemory> devices_;
    std::uint64_t absences_ = 0;
    RateLimit absence_limit_ = log_limit();
    CanReport can_;
    SensorBusLog sensor_buses_;
    NodeLog nodes_;
};

}  // namespace tribus
