#include "app/log/sensor_bus_log.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "app/journal/log.h"
#include "app/journal/log_fields.h"
#include "app/log/doctor_hint.h"
#include "app/log/port_of.h"
#include "app/state_text/cause_text.h"
#include "app/state_text/part_text.h"
#include "core/counted.h"

namespace tribus {
namespace {

/// Receivers and sensors that are on have sent by then; a receiver needs 0.6 s to start.
constexpr Duration kFirstWait = std::chrono::seconds(3);
/// A single collision or late reply costs one slot, which the receiver repeats.
constexpr std::uint64_t kWorthLogging = 10;

template <class... Arguments>
void log_limited(RateLimit& limit, Instant now, LogLevel level,
                 fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    if (const auto swallowed = limit.pass(now)) {
        log_at(level, "{}{}", fmt::format(format, std::forward<Arguments>(arguments)...),
               swallowed_note(*swallowed));
    }
}

std::string places_text(std::size_t first, std::size_t count) {
    return count == 1 ? fmt::format("a sensor at address {}", first)
                      : fmt::format("sensors at addresses {} to {}", first, first + count - 1);
}

}  // namespace

SensorBusLog::SensorBusLog(const Appliance& appliance, Instant start) {
    const Configuration& configuration = appliance.configuration();
    for (const SensorBusConfig& bus : configuration.sensor_buses) {
        buses_.push_back({.name = bus.name,
                          .doctor_hint = doctor_hint(bus.port),
                          .sensors = bus.sensors.size(),
                          .types = SensorTypes(bus.dialect, configuration.sensor_types),
                          .start = start});
    }
}

void SensorBusLog::go_on_from(const SensorBusLog& before, std::span<const CarriedFrom> from) {
    for (std::size_t i = 0; i < buses_.size(); ++i) {
        if (from[i]) {
            buses_[i] = before.buses_[*from[i]];
        }
    }
}

std::string SensorBusLog::type_name(const Memory& memory, std::uint8_t type) {
    const SensorType* known = memory.types.find(type);
    if (known == nullptr) {
        return fmt::format("a sensor of the unknown type {:02x}", type);
    }
    return in_words(known->name);
}

void SensorBusLog::look_at_sensor(const SensorBusState& state, Memory& memory, Instant now) {
    const bool asked = is_asked(state.latest_request, now);
    if (const auto swallowed = memory.asked.look(asked, memory.limit, now)) {
        const std::string note = swallowed_note(*swallowed);
        if (asked && state.first_address == 0) {
            log_info("sensor bus {}: a receiver sends requests; waiting for an address{}",
                     memory.name, note);
        } else if (asked) {
            log_info("sensor bus {}: a receiver sends requests; {}{}", memory.name,
                     places_text(state.first_address, memory.sensors), note);
        } else {
            log_warning("sensor bus {}: the receiver sends no more requests{}", memory.name, note);
        }
    }
    if (!memory.missing_signal_logged && state.sensor.requests == 0 &&
        now - memory.start >= kFirstWait) {
        memory.missing_signal_logged = true;
        log_warning(
            "sensor bus {}: no request yet; check wire, ground and power, and that it is the "
            "receiver's SENS port{}",
            memory.name, memory.doctor_hint);
    }
}

void SensorBusLog::look_at_address(const std::optional<FoundSensor>& found, std::size_t address,
                                   Memory& memory, Instant now) {
    FoundMemory& at = memory.found[address - 1];
    const std::optional<FoundSensor> before = at.sensor.reported();
    const auto swallowed = at.sensor.look(found, at.limit, now);
    if (!swallowed) {
        return;
    }
    if (before) {
        log_warning("sensor bus {}: address {}, {}, is gone{}", memory.name, address,
                    type_name(memory, before->type), swallowed_note(*swallowed));
    }
    if (found) {
        log_found(memory, address, *found, before ? "" : swallowed_note(*swallowed));
    }
}

void SensorBusLog::log_found(const Memory& memory, std::size_t address, const FoundSensor& found,
                             const std::string& note) {
    const SensorType* const type = memory.types.find(found.type);
    if (type == nullptr || is_readable(*type, found.size)) {
        log_info("sensor bus {}: address {} is {}{}", memory.name, address,
                 type_name(memory, found.type), note);
        return;
    }
    log_warning(
        "sensor bus {}: address {} is {}, but reports values of {}, where that type has "
        "{}; a [sensor_type] of your own with that id and size defines them{}",
        memory.name, address, type_name(memory, found.type), counted(found.size, "byte"),
        type->size, note);
}

/// A sensor that answers, and of which nothing can be read all the same.
void SensorBusLog::look_at_fault(const SensorBusState& state, std::size_t address, Memory& memory,
                                 Instant now) {
    FoundMemory& at = memory.found[address - 1];
    const SensorFault before = at.fault.reported();
    const SensorFault& fault = state.faults[address - 1];
    const auto swallowed = at.fault.look(fault, at.fault_limit, now);
    if (!swallowed) {
        return;
    }
    const std::string note = swallowed_note(*swallowed);
    const bool is_found = address <= state.found_count;
    switch (fault.kind) {
        case SensorFault::Kind::no_type:
            log_warning(
                "sensor bus {}: a sensor at address {} answers, but never reports its type; "
                "neither it nor a sensor at a higher address is read. Are there two sensors at "
                "this address, or is this no i.Bus sensor?{}",
                memory.name, address, note);
            break;
        case SensorFault::Kind::wrong_size:
            log_warning(
                "sensor bus {}: the values of address {} have {}, but the sensor reported {} with "
                "its type; they are not read{}",
                memory.name, address, counted(fault.sent_size, "byte"),
                is_found ? state.found[address - 1].size : 0, note);
            break;
        case SensorFault::Kind::none:
            if (before.kind == SensorFault::Kind::wrong_size && is_found) {
                log_info("sensor bus {}: the values of address {} have {} again, as it reported{}",
                         memory.name, address, counted(state.found[address - 1].size, "byte"),
                         note);
            } else if (before.kind == SensorFault::Kind::no_type && !is_found) {
                log_info("sensor bus {}: address {} no longer answers{}", memory.name, address,
                         note);
            }
            break;
    }
}

void SensorBusLog::look_at_receiver(const SensorBusState& state, Memory& memory, Instant now) {
    for (std::size_t i = 0; i < kMostSensors; ++i) {
        look_at_address(i < state.found_count ? std::optional(state.found[i]) : std::nullopt, i + 1,
                        memory, now);
        look_at_fault(state, i + 1, memory, now);
    }
    const bool answers = state.found_count > 0 || state.faults != SensorFaults{};
    if (!memory.missing_signal_logged && !answers && now - memory.start >= kFirstWait) {
        memory.missing_signal_logged = true;
        log_warning(
            "sensor bus {}: no sensor replies yet; check wire, ground and power{}", memory.name,
            state.echo.returned == 0 ? ", and that TX and RX are joined if it is one wire" : "");
    }
}

void SensorBusLog::look_at_troubles(const SensorBusState& state, Memory& memory, Instant now) {
    if (state.echo.collisions >= memory.collisions + kWorthLogging) {
        log_limited(memory.limit, now, LogLevel::warning,
                    "sensor bus {}: {} of its frames came back altered; two devices send at the "
                    "same time, perhaps with the same address, or the wire is disturbed",
                    memory.name, state.echo.collisions - memory.collisions);
        memory.collisions = state.echo.collisions;
    }
    if (state.sensor.late >= memory.late + kWorthLogging) {
        log_limited(memory.limit, now, LogLevel::warning,
                    "sensor bus {}: {} replies not sent because they were late; `tribus bench` "
                    "shows what delays this board",
                    memory.name, state.sensor.late - memory.late);
        memory.late = state.sensor.late;
    }
}

void SensorBusLog::look(const Appliance& appliance, Instant now) {
    for (std::size_t i = 0; i < buses_.size(); ++i) {
        const SensorBusState state = appliance.bus_state(i);
        const LogFields fields({"TRIBUS_SENSOR_BUS", buses_[i].name});
        const Station bus{.kind = StationKind::sensor_bus, .index = i};
        if (!appliance.port_present(port_of(appliance, bus))) {
            // Nothing can come before the device is there. Another message says that it is missing.
            buses_[i].start = now;
        }
        if (state.is_receiver) {
            look_at_receiver(state, buses_[i], now);
        } else {
            look_at_sensor(state, buses_[i], now);
        }
        look_at_troubles(state, buses_[i], now);
    }
}

}  // namespace tribus
