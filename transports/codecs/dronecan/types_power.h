#pragma once

#include <cstdint>
#include <string_view>
#include <tuple>

#include "transports/codecs/dronecan/bounded_array.h"
#include "transports/codecs/dronecan/fields.h"
#include "transports/codecs/dronecan/timestamp.h"

/// Batteries and supplies. Source: the DSDL files of these names in dronecan/DSDL;
/// docs/protocols/can.md, "DroneCAN: telemetry".
namespace tribus::dronecan {

/// Unknown floats are NaN.
struct BatteryInfo {
    static constexpr std::string_view kName = "uavcan.equipment.power.BatteryInfo";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1092;
    static constexpr std::uint64_t kSignature = 0x249C26548A711966;

    /// Bits of status_flags.
    static constexpr std::uint16_t kInUse = 1;
    static constexpr std::uint16_t kCharging = 2;
    static constexpr std::uint16_t kCharged = 4;
    static constexpr std::uint16_t kTemperatureHot = 8;
    static constexpr std::uint16_t kTemperatureCold = 16;
    static constexpr std::uint16_t kOverload = 32;
    static constexpr std::uint16_t kBadBattery = 64;
    static constexpr std::uint16_t kNeedService = 128;
    static constexpr std::uint16_t kBmsError = 256;

    static constexpr std::uint8_t kStateOfHealthUnknown = 127;

    float temperature = 0;
    float voltage = 0;
    float current = 0;  ///< positive: discharging
    float average_power_10sec = 0;
    float remaining_capacity_wh = 0;
    float full_charge_capacity_wh = 0;
    float hours_to_full_charge = 0;
    std::uint16_t status_flags = 0;
    std::uint8_t state_of_health_pct = kStateOfHealthUnknown;
    std::uint8_t state_of_charge_pct = 0;
    std::uint8_t state_of_charge_pct_stdev = 0;
    std::uint8_t battery_id = 0;
    std::uint32_t model_instance_id = 0;
    BoundedText<31> model_name;

    bool operator==(const BatteryInfo&) const = default;

    static constexpr auto fields() {
        return std::tuple(
            field<Float16>("temperature", &BatteryInfo::temperature, "K"),
            field<Float16>("voltage", &BatteryInfo::voltage, "V"),
            field<Float16>("current", &BatteryInfo::current, "A"),
            field<Float16>("average_power_10sec", &BatteryInfo::average_power_10sec, "W"),
            field<Float16>("remaining_capacity_wh", &BatteryInfo::remaining_capacity_wh, "Wh"),
            field<Float16>("full_charge_capacity_wh", &BatteryInfo::full_charge_capacity_wh, "Wh"),
            field<Float16>("hours_to_full_charge", &BatteryInfo::hours_to_full_charge, "h"),
            field<Unsigned<11>>("status_flags", &BatteryInfo::status_flags),
            field<Unsigned<7>>("state_of_health_pct", &BatteryInfo::state_of_health_pct, "%"),
            field<Unsigned<7>>("state_of_charge_pct", &BatteryInfo::state_of_charge_pct, "%"),
            field<Unsigned<7>>("state_of_charge_pct_stdev", &BatteryInfo::state_of_charge_pct_stdev,
                               "%"),
            field<Unsigned<8>>("battery_id", &BatteryInfo::battery_id),
            field<Unsigned<32>>("model_instance_id", &BatteryInfo::model_instance_id),
            field<ArrayOf<Unsigned<8>>>("model_name", &BatteryInfo::model_name));
    }
};

struct CircuitStatus {
    static constexpr std::string_view kName = "uavcan.equipment.power.CircuitStatus";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1091;
    static constexpr std::uint64_t kSignature = 0x8313D33D0DDDA115;

    /// Bits of error_flags.
    static constexpr std::uint8_t kOvervoltage = 1;
    static constexpr std::uint8_t kUndervoltage = 2;
    static constexpr std::uint8_t kOvercurrent = 4;
    static constexpr std::uint8_t kUndercurrent = 8;

    std::uint16_t circuit_id = 0;
    float voltage = 0;
    float current = 0;
    std::uint8_t error_flags = 0;

    bool operator==(const CircuitStatus&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<16>>("circuit_id", &CircuitStatus::circuit_id),
                          field<Float16>("voltage", &CircuitStatus::voltage, "V"),
                          field<Float16>("current", &CircuitStatus::current, "A"),
                          field<Unsigned<8>>("error_flags", &CircuitStatus::error_flags));
    }
};

struct BatteryCells {
    static constexpr std::string_view kName = "ardupilot.equipment.power.BatteryCells";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 20012;
    static constexpr std::uint64_t kSignature = 0x5C8B1ABD15890EA4;

    BoundedArray<float, 24> voltages;
    std::uint16_t index = 0;  ///< of the first voltage, counted from 0

    bool operator==(const BatteryCells&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<ArrayOf<Float16>>("voltages", &BatteryCells::voltages, "V"),
                          field<Unsigned<16>>("index", &BatteryCells::index));
    }
};

/// Sent before the BatteryInfo that it belongs to.
struct BatteryInfoAux {
    static constexpr std::string_view kName = "ardupilot.equipment.power.BatteryInfoAux";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 20004;
    static constexpr std::uint64_t kSignature = 0x7D7F49FC75484882;

    Timestamp timestamp;  ///< of the latest measurement of the current
    BoundedArray<float, 255> voltage_cell;
    std::uint16_t cycle_count = 0;
    std::uint16_t over_discharge_count = 0;
    float max_current = 0;  ///< since the message before
    float nominal_voltage = 0;
    bool is_powering_off = false;
    std::uint8_t battery_id = 0;

    bool operator==(const BatteryInfoAux&) const = default;

    static constexpr auto fields() {
        return std::tuple(
            field<Nested>("timestamp", &BatteryInfoAux::timestamp),
            field<ArrayOf<Float16>>("voltage_cell", &BatteryInfoAux::voltage_cell, "V"),
            field<Unsigned<16>>("cycle_count", &BatteryInfoAux::cycle_count),
            field<Unsigned<16>>("over_discharge_count", &BatteryInfoAux::over_discharge_count),
            field<Float16>("max_current", &BatteryInfoAux::max_current, "A"),
            field<Float16>("nominal_voltage", &BatteryInfoAux::nominal_voltage, "V"),
            field<Boolean>("is_powering_off", &BatteryInfoAux::is_powering_off),
            field<Unsigned<8>>("battery_id", &BatteryInfoAux::battery_id));
    }
};

}  // namespace tribus::dronecan
