#pragma once

#include <cstdint>
#include <string_view>
#include <tuple>

#include "transports/codecs/dronecan/bounded_array.h"
#include "transports/codecs/dronecan/fields.h"

/// Messages that move things or permit it: channels of a receiver, commands to servos and ESCs,
/// arming. Source: the DSDL files of these names in dronecan/DSDL; docs/protocols/can.md,
/// "DroneCAN: RCInput" and "DroneCAN: commands".
namespace tribus::dronecan {

struct RcInput {
    static constexpr std::string_view kName = "dronecan.sensors.rc.RCInput";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1140;
    static constexpr std::uint64_t kSignature = 0x771555E596AAB4CF;

    /// Bits of the status.
    static constexpr std::uint16_t kQualityValid = 0x01;
    static constexpr std::uint16_t kFailsafe = 0x02;
    static constexpr std::uint16_t kQualityTypeMask = 0x1C;
    /// Kind of the quality, in the bits of kQualityTypeMask.
    static constexpr std::uint16_t kQualityTypeRssi = 0;  ///< 0 none to 255 full
    /// Percent in bits 0 to 6, the antenna in use in bit 7.
    static constexpr std::uint16_t kQualityTypeLinkQuality = 4;
    static constexpr std::uint16_t kQualityTypeRssiDbm = 8;   ///< 0 none, 1 to 255: dBm below 0
    static constexpr std::uint16_t kQualityTypeSnr = 12;      ///< units of the device, plus 128
    static constexpr std::uint16_t kQualityTypeTxPower = 16;  ///< units of 5 mW

    std::uint16_t status = 0;
    std::uint8_t quality = 0;
    std::uint8_t id = 0;                   ///< number of the receiver on this node; 0 to 15
    BoundedArray<std::uint16_t, 32> rcin;  ///< microseconds, 0 to 4095

    bool operator==(const RcInput&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<16>>("status", &RcInput::status),
                          field<Unsigned<8>>("quality", &RcInput::quality),
                          field<Unsigned<4>>("id", &RcInput::id),
                          field<ArrayOf<Unsigned<12>>>("rcin", &RcInput::rcin, "us"));
    }
};

struct ActuatorCommand {
    static constexpr std::string_view kName = "uavcan.equipment.actuator.Command";

    static constexpr std::uint8_t kUnitless = 0;  ///< -1 to 1
    static constexpr std::uint8_t kPosition = 1;  ///< m or rad
    static constexpr std::uint8_t kForce = 2;     ///< N or Nm
    static constexpr std::uint8_t kSpeed = 3;     ///< m/s or rad/s
    static constexpr std::uint8_t kPwm = 4;       ///< microseconds

    std::uint8_t actuator_id = 0;
    std::uint8_t command_type = kUnitless;
    float command_value = 0;

    bool operator==(const ActuatorCommand&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<8>>("actuator_id", &ActuatorCommand::actuator_id),
                          field<Unsigned<8>>("command_type", &ActuatorCommand::command_type),
                          field<Float16>("command_value", &ActuatorCommand::command_value));
    }
};

struct ArrayCommand {
    static constexpr std::string_view kName = "uavcan.equipment.actuator.ArrayCommand";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1010;
    static constexpr std::uint64_t kSignature = 0xD8A7486238EC3AF3;

    BoundedArray<ActuatorCommand, 15> commands;

    bool operator==(const ArrayCommand&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<ArrayOf<Nested>>("commands", &ArrayCommand::commands));
    }
};

struct EscRawCommand {
    static constexpr std::string_view kName = "uavcan.equipment.esc.RawCommand";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1030;
    static constexpr std::uint64_t kSignature = 0x217F5C87D7EC951D;

    BoundedArray<std::int16_t, 20> cmd;  ///< one for each ESC, by its number; -8192 to 8191

    bool operator==(const EscRawCommand&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<ArrayOf<Signed<14>>>("cmd", &EscRawCommand::cmd));
    }
};

struct ArmingStatus {
    static constexpr std::string_view kName = "uavcan.equipment.safety.ArmingStatus";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1100;
    static constexpr std::uint64_t kSignature = 0x8700F375556A8003;

    static constexpr std::uint8_t kDisarmed = 0;
    static constexpr std::uint8_t kFullyArmed = 255;

    std::uint8_t status = kDisarmed;

    bool operator==(const ArmingStatus&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<8>>("status", &ArmingStatus::status));
    }
};

struct SafetyState {
    static constexpr std::string_view kName = "ardupilot.indication.SafetyState";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 20000;
    static constexpr std::uint64_t kSignature = 0xE965701A95A1A6A1;

    static constexpr std::uint8_t kSafetyOn = 0;
    static constexpr std::uint8_t kSafetyOff = 255;

    std::uint8_t status = kSafetyOn;

    bool operator==(const SafetyState&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<8>>("status", &SafetyState::status));
    }
};

struct NotifyState {
    static constexpr std::string_view kName = "ardupilot.indication.NotifyState";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 20007;
    static constexpr std::uint64_t kSignature = 0x631F2A9C1651FDEC;

    /// Numbers of bits in vehicle_state.
    static constexpr unsigned kInitialising = 0;
    static constexpr unsigned kArmed = 1;
    static constexpr unsigned kFlying = 2;
    static constexpr unsigned kPrearm = 3;
    static constexpr unsigned kPrearmGps = 4;
    static constexpr unsigned kSaveTrim = 5;
    static constexpr unsigned kEscCalibration = 6;
    static constexpr unsigned kFailsafeRadio = 7;
    static constexpr unsigned kFailsafeBattery = 8;
    static constexpr unsigned kFailsafeGcs = 9;
    static constexpr unsigned kChuteReleased = 10;
    static constexpr unsigned kEkfBad = 11;
    static constexpr unsigned kFirmwareUpdate = 12;
    static constexpr unsigned kMagcalRun = 13;
    static constexpr unsigned kLeakDetected = 14;
    static constexpr unsigned kGpsFusion = 15;
    static constexpr unsigned kGpsGlitch = 16;
    static constexpr unsigned kPositionAbsoluteAvailable = 17;
    static constexpr unsigned kLost = 18;
    static constexpr unsigned kThrowReady = 19;
    static constexpr unsigned kPoweringOff = 20;
    static constexpr unsigned kVideoRecording = 21;

    /// aux_data is the heading in hundredths of a degree, 16 bits.
    static constexpr std::uint8_t kVehicleYawEarthCentidegrees = 0;

    std::uint8_t aux_data_type = 0;
    BoundedArray<std::uint8_t, 255> aux_data;
    std::uint64_t vehicle_state = 0;

    bool operator==(const NotifyState&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<8>>("aux_data_type", &NotifyState::aux_data_type),
                          field<ArrayOf<Unsigned<8>>>("aux_data", &NotifyState::aux_data),
                          field<Unsigned<64>>("vehicle_state", &NotifyState::vehicle_state));
    }
};

}  // namespace tribus::dronecan
