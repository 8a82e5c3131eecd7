#pragma once

#include <cstdint>
#include <string_view>
#include <tuple>

#include "transports/codecs/dronecan/fields.h"

/// Motors, temperatures, air, fuel. Source: the DSDL files of these names in dronecan/DSDL;
/// docs/protocols/can.md, "DroneCAN: telemetry".
namespace tribus::dronecan {

struct EscStatus {
    static constexpr std::string_view kName = "uavcan.equipment.esc.Status";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1034;
    static constexpr std::uint64_t kSignature = 0xA9AF28AEA2FBB254;

    std::uint32_t error_count = 0;  ///< since the motor started
    float voltage = 0;
    float current = 0;  ///< negative: regenerative braking
    float temperature = 0;
    std::int32_t rpm = 0;               ///< negative: reverse
    std::uint8_t power_rating_pct = 0;  ///< share of the power that the ESC can give; at most 127
    std::uint8_t esc_index = 0;

    bool operator==(const EscStatus&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<32>>("error_count", &EscStatus::error_count),
                          field<Float16>("voltage", &EscStatus::voltage, "V"),
                          field<Float16>("current", &EscStatus::current, "A"),
                          field<Float16>("temperature", &EscStatus::temperature, "K"),
                          field<Signed<18>>("rpm", &EscStatus::rpm, "rpm"),
                          field<Unsigned<7>>("power_rating_pct", &EscStatus::power_rating_pct, "%"),
                          field<Unsigned<5>>("esc_index", &EscStatus::esc_index));
    }
};

struct EscStatusExtended {
    static constexpr std::string_view kName = "uavcan.equipment.esc.StatusExtended";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1036;
    static constexpr std::uint64_t kSignature = 0x02DC203C50960EDC;

    std::uint8_t input_pct = 0;   ///< commanded
    std::uint8_t output_pct = 0;  ///< to the motor
    std::int16_t motor_temperature = 0;
    std::uint16_t motor_angle = 0;
    std::uint32_t status_flags = 0;  ///< defined by the manufacturer
    std::uint8_t esc_index = 0;

    bool operator==(const EscStatusExtended&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<7>>("input_pct", &EscStatusExtended::input_pct, "%"),
                          field<Unsigned<7>>("output_pct", &EscStatusExtended::output_pct, "%"),
                          field<Signed<9>>("motor_temperature_degC",
                                           &EscStatusExtended::motor_temperature, "degC"),
                          field<Unsigned<9>>("motor_angle", &EscStatusExtended::motor_angle, "deg"),
                          field<Unsigned<19>>("status_flags", &EscStatusExtended::status_flags),
                          field<Unsigned<5>>("esc_index", &EscStatusExtended::esc_index));
    }
};

struct DeviceTemperature {
    static constexpr std::string_view kName = "uavcan.equipment.device.Temperature";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1110;
    static constexpr std::uint64_t kSignature = 0x70261C28A94144C6;

    /// Bits of error_flags.
    static constexpr std::uint8_t kOverheating = 1;
    static constexpr std::uint8_t kOvercooling = 2;

    std::uint16_t device_id = 0;
    float temperature = 0;
    std::uint8_t error_flags = 0;

    bool operator==(const DeviceTemperature&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<16>>("device_id", &DeviceTemperature::device_id),
                          field<Float16>("temperature", &DeviceTemperature::temperature, "K"),
                          field<Unsigned<8>>("error_flags", &DeviceTemperature::error_flags));
    }
};

struct StaticPressure {
    static constexpr std::string_view kName = "uavcan.equipment.air_data.StaticPressure";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1028;
    static constexpr std::uint64_t kSignature = 0xCDC7C43412BDC89A;

    float static_pressure = 0;
    float static_pressure_variance = 0;

    bool operator==(const StaticPressure&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Float32>("static_pressure", &StaticPressure::static_pressure, "Pa"),
                          field<Float16>("static_pressure_variance",
                                         &StaticPressure::static_pressure_variance, "Pa^2"));
    }
};

struct StaticTemperature {
    static constexpr std::string_view kName = "uavcan.equipment.air_data.StaticTemperature";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1029;
    static constexpr std::uint64_t kSignature = 0x49272A6477D96271;

    float static_temperature = 0;
    float static_temperature_variance = 0;

    bool operator==(const StaticTemperature&) const = default;

    static constexpr auto fields() {
        return std::tuple(
            field<Float16>("static_temperature", &StaticTemperature::static_temperature, "K"),
            field<Float16>("static_temperature_variance",
                           &StaticTemperature::static_temperature_variance, "K^2"));
    }
};

struct FuelTankStatus {
    static constexpr std::string_view kName = "uavcan.equipment.ice.FuelTankStatus";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1129;
    static constexpr std::uint64_t kSignature = 0x286B4A387BA84BC4;

    std::uint8_t available_fuel_volume_percent = 0;
    float available_fuel_volume_cm3 = 0;
    float fuel_consumption_rate_cm3pm = 0;  ///< negative: filled from another tank
    float fuel_temperature = 0;             ///< NaN: unknown
    std::uint8_t fuel_tank_id = 0;

    bool operator==(const FuelTankStatus&) const = default;

    static constexpr auto fields() {
        return std::tuple(
            Padding<9>{},
            field<Unsigned<7>>("available_fuel_volume_percent",
                               &FuelTankStatus::available_fuel_volume_percent, "%"),
            field<Float32>("available_fuel_volume_cm3", &FuelTankStatus::available_fuel_volume_cm3,
                           "cm3"),
            field<Float32>("fuel_consumption_rate_cm3pm",
                           &FuelTankStatus::fuel_consumption_rate_cm3pm, "cm3/min"),
            field<Float16>("fuel_temperature", &FuelTankStatus::fuel_temperature, "K"),
            field<Unsigned<8>>("fuel_tank_id", &FuelTankStatus::fuel_tank_id));
    }
};

struct Rpm {
    static constexpr std::string_view kName = "dronecan.sensors.rpm.RPM";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1045;
    static constexpr std::uint64_t kSignature = 0x140707C09274F6E7;

    /// Bit of flags.
    static constexpr std::uint16_t kUnhealthy = 1;

    std::uint8_t sensor_id = 0;
    std::uint16_t flags = 0;
    float rpm = 0;

    bool operator==(const Rpm&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<8>>("sensor_id", &Rpm::sensor_id),
                          field<Unsigned<16>>("flags", &Rpm::flags),
                          field<Float32>("rpm", &Rpm::rpm, "rpm"));
    }
};

}  // namespace tribus::dronecan
