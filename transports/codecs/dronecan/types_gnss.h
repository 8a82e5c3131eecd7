#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <tuple>

#include "transports/codecs/dronecan/bounded_array.h"
#include "transports/codecs/dronecan/fields.h"
#include "transports/codecs/dronecan/timestamp.h"

/// Satellite navigation. Source: the DSDL files of these names in dronecan/DSDL;
/// docs/protocols/can.md, "DroneCAN: telemetry".
namespace tribus::dronecan {

/// In the earth-centred, earth-fixed frame.
struct EcefPositionVelocity {
    static constexpr std::string_view kName = "uavcan.equipment.gnss.ECEFPositionVelocity";

    std::array<float, 3> velocity_xyz{};
    std::array<std::int64_t, 3> position_xyz_mm{};
    BoundedArray<float, 36> covariance;

    bool operator==(const EcefPositionVelocity&) const = default;

    static constexpr auto fields() {
        return std::tuple(
            field<ArrayOf<Float32>>("velocity_xyz", &EcefPositionVelocity::velocity_xyz, "m/s"),
            field<ArrayOf<Signed<36>>>("position_xyz_mm", &EcefPositionVelocity::position_xyz_mm,
                                       "mm"),
            Padding<6>{}, field<ArrayOf<Float16>>("covariance", &EcefPositionVelocity::covariance));
    }
};

struct GnssFix2 {
    static constexpr std::string_view kName = "uavcan.equipment.gnss.Fix2";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1063;
    static constexpr std::uint64_t kSignature = 0xCA41E7000F37435F;

    /// Clock of gnss_timestamp.
    static constexpr std::uint8_t kTimeStandardNone = 0;
    static constexpr std::uint8_t kTimeStandardTai = 1;
    static constexpr std::uint8_t kTimeStandardUtc = 2;
    static constexpr std::uint8_t kTimeStandardGps = 3;

    static constexpr std::uint8_t kLeapSecondsUnknown = 0;

    static constexpr std::uint8_t kStatusNoFix = 0;
    static constexpr std::uint8_t kStatusTimeOnly = 1;
    static constexpr std::uint8_t kStatus2dFix = 2;
    static constexpr std::uint8_t kStatus3dFix = 3;

    static constexpr std::uint8_t kModeSingle = 0;
    static constexpr std::uint8_t kModeDgps = 1;
    static constexpr std::uint8_t kModeRtk = 2;
    static constexpr std::uint8_t kModePpp = 3;

    /// Sub-modes of kModeDgps and of kModeRtk.
    static constexpr std::uint8_t kSubModeDgpsOther = 0;
    static constexpr std::uint8_t kSubModeDgpsSbas = 1;
    static constexpr std::uint8_t kSubModeRtkFloat = 0;
    static constexpr std::uint8_t kSubModeRtkFixed = 1;

    Timestamp timestamp;
    Timestamp gnss_timestamp;
    std::uint8_t gnss_time_standard = 0;
    std::uint8_t num_leap_seconds = 0;
    std::int64_t longitude_deg_1e8 = 0;
    std::int64_t latitude_deg_1e8 = 0;
    std::int32_t height_ellipsoid_mm = 0;
    std::int32_t height_msl_mm = 0;
    std::array<float, 3> ned_velocity{};  ///< north, east, down
    std::uint8_t sats_used = 0;
    std::uint8_t status = 0;
    std::uint8_t mode = 0;
    std::uint8_t sub_mode = 0;
    BoundedArray<float, 36> covariance;  ///< of position (m) and velocity (m/s)
    float pdop = 0;
    BoundedArray<EcefPositionVelocity, 1> ecef_position_velocity;

    bool operator==(const GnssFix2&) const = default;

    static constexpr auto fields() {
        return std::tuple(
            field<Nested>("timestamp", &GnssFix2::timestamp),
            field<Nested>("gnss_timestamp", &GnssFix2::gnss_timestamp),
            field<Unsigned<3>>("gnss_time_standard", &GnssFix2::gnss_time_standard), Padding<13>{},
            field<Unsigned<8>>("num_leap_seconds", &GnssFix2::num_leap_seconds),
            field<Signed<37>>("longitude_deg_1e8", &GnssFix2::longitude_deg_1e8, "1e-8 deg"),
            field<Signed<37>>("latitude_deg_1e8", &GnssFix2::latitude_deg_1e8, "1e-8 deg"),
            field<Signed<27>>("height_ellipsoid_mm", &GnssFix2::height_ellipsoid_mm, "mm"),
            field<Signed<27>>("height_msl_mm", &GnssFix2::height_msl_mm, "mm"),
            field<ArrayOf<Float32>>("ned_velocity", &GnssFix2::ned_velocity, "m/s"),
            field<Unsigned<6>>("sats_used", &GnssFix2::sats_used),
            field<Unsigned<2>>("status", &GnssFix2::status),
            field<Unsigned<4>>("mode", &GnssFix2::mode),
            field<Unsigned<6>>("sub_mode", &GnssFix2::sub_mode),
            field<ArrayOf<Float16>>("covariance", &GnssFix2::covariance),
            field<Float16>("pdop", &GnssFix2::pdop),
            field<ArrayOf<Nested>>("ecef_position_velocity", &GnssFix2::ecef_position_velocity));
    }
};

}  // namespace tribus::dronecan
