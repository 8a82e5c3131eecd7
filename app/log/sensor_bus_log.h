#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/appliance/appliance.h"
#include "app/journal/log_limit.h"
#include "core/change_report.h"
#include "core/rate_limit.h"
#include "core/time.h"
#include "pipelines/engine/carry_over.h"
#include "transports/codecs/ibus_sensor/types.h"

namespace tribus {

/// Logs what changed on the sensor buses; logs nothing while nothing changes. Thread-bound to the
/// main thread.
class SensorBusLog {
  public:
    SensorBusLog(const Appliance& appliance, Instant start);

    /// After a reload: takes over what `before` knows about the buses that go on.
    void go_on_from(const SensorBusLog& before, std::span<const CarriedFrom> from);
    /// Logs changes since the last call. Call it a few times a second.
    void look(const Appliance& appliance, Instant now);

  private:
    /// One address. Each has its own limit, so that an unstable sensor uses up no lines of others.
    struct FoundMemory {
        ChangeReport<std::optional<FoundSensor>> sensor{std::nullopt};
        RateLimit limit = log_limit();
        ChangeReport<SensorFault> fault{SensorFault{}};
        RateLimit fault_limit = log_limit();
    };
    struct Memory {
        std::string name;
        std::string doctor_hint;
        std::size_t sensors = 0;  ///< role sensor: how many
        SensorTypes types;
        Instant start;
        RateLimit limit = log_limit();
        bool missing_signal_logged = false;
        ChangeReport<bool> asked{
            false};  ///< role sensor: a receiver sent a request in the last second
        std::array<FoundMemory, kMostSensors> found{};
        std::uint64_t collisions = 0;
        std::uint64_t late = 0;
    };

    void look_at_sensor(const SensorBusState& state, Memory& memory, Instant now);
    void look_at_receiver(const SensorBusState& state, Memory& memory, Instant now);
    static void look_at_address(const std::optional<FoundSensor>& found, std::size_t address,
                                Memory& memory, Instant now);
    static void look_at_fault(const SensorBusState& state, std::size_t address, Memory& memory,
                              Instant now);
    static void look_at_troubles(const SensorBusState& state, Memory& memory, Instant now);
    static std::string type_name(const Memory& memory, std::uint8_t type);
    static void log_found(const Memory& memory, std::size_t address, const FoundSensor& found,
                          const std::string& note);

    std::vector<Memory> buses_;
};

}  // namespace tribus
