#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/appliance/appliance.h"
#include "app/journal/log_limit.h"
#include "app/log/can_report.h"
#include "app/log/sensor_bus_log.h"
#include "config/build/carry_over.h"
#include "core/rate_limit.h"
#include "core/time.h"

namespace tribus {

/// Logs what somebody must know besides changes of state; logs nothing while all is well.
/// Thread-bound to the main thread.
class StateLog {
  public:
    StateLog(const Appliance& appliance, Instant start);

    /// Logs how each CAN interface is configured.
    void log_interfaces(const Appliance& appliance) { can_.start(appliance); }
    /// After a reload: does not repeat what `before` said about the parts that go on.
    void go_on_from(const StateLog& before, const Appliance& appliance,
                    const CarryOver& carry_over);

    /// Logs what is new since the last call, at most a few lines per time for each input, output
    /// and device. `news`: of the appliance, since the last call.
    void look(const Appliance& appliance, const Appliance::DeviceNews& news, Instant now);

  private:
    struct InputMemory {
        /// Since when something may come.
        Instant start;
        bool missing_signal_logged = false;
        bool two_senders_logged = false;
        /// Places of the counters of what a key does not prove, and what they were when told.
        std::vector<std::size_t> unproved_causes{};
        std::uint64_t unproved = 0;
        RateLimit unproved_limit{1, std::chrono::minutes(1)};
        std::uint64_t implausible = 0;
        RateLimit implausible_limit{1, std::chrono::minutes(1)};
    };
    struct OutputMemory {
        /// The bits of `OutputState::by_preset` that were logged already.
        std::uint32_t presets_logged = 0;
        std::uint64_t busy_drops = 0;
        std::uint64_t foreign_frames = 0;
        /// Answers that were heard before the output was in control, and what was logged of those
        /// since then.
        Answers before{};
        std::string advice;
        RateLimit drops_limit = log_limit();
        RateLimit foreign_limit = log_limit();
    };
    void look_at_absence(const AbsenceStatus& absence, Instant now);
    static void look_for_two_senders(const std::string& name, const InputStatus& status,
                                     InputMemory& memory);
    static void look_at_implausible(const std::string& name, const InputStatus& status,
                                    InputMemory& memory, Instant now);
    static void look_at_unproved(const std::string& name, const InputStatus& status,
                                 InputMemory& memory, Instant now);
    static void look_at_presets(const std::string& name, const OutputStatus& status,
                                OutputMemory& memory);
    void look_at_answers(const OutputConfig& output, const OutputStatus& status,
                         OutputMemory& memory) const;
    void look_at_drops(const std::string& name, const OutputStatus& status, OutputMemory& memory,
                       Instant now);
    static bool knows_the_reason(const InputStatus& status);
    static void log_missing_signal(const std::string& name, const InputStatus& status,
                                   const PortPlan& port, InputMemory& memory, Instant now);

    std::vector<InputMemory> inputs_;
    std::vector<OutputMemory> outputs_;
    std::uint64_t absences_ = 0;
    RateLimit absence_limit_ = log_limit();
    CanReport can_;
    SensorBusLog sensor_buses_;
};

}  // namespace tribus
