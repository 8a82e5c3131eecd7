#include "transports/codecs/ibus_sensor/types.h"

#include <algorithm>
#include <utility>

namespace tribus {
namespace {

enum class Sign : std::uint8_t {
    none,
    twos_complement,
    /// -18000 to 47535: reads both -180.00 to 180.00 degrees and 0 to 360.00 degrees correctly.
    either_turn,
};
constexpr Sign kNone = Sign::none;
constexpr Sign kSigned = Sign::twos_complement;
constexpr Sign kTurn = Sign::either_turn;
constexpr std::int64_t kLeastOfTurn = -18000;

/// One field. A type with several fields has one row for each, in order.
struct Row {
    std::uint8_t id;
    std::string_view type;
    std::uint8_t size;
    std::string_view field;
    std::string_view unit;
    unsigned first_bit;
    unsigned bits;
    Sign sign;
    double scale = 1;
    double offset = 0;
    std::optional<std::int64_t> not_available{};
};

constexpr double kColdest = -40;  // degrees Celsius of raw 0, for every temperature
constexpr double kMilliGravity = 9.80665 / 1000;

/// The types of docs/protocols/ibus.md, "Sensor types". Where sources disagree, the row follows
/// FlySky's own sensors and transmitters, or else most of the others. The tables below have the
/// rows of those that differ.
constexpr Row kFlysky[] = {
    {0x00, "internal_voltage", 2, "voltage", "V", 0, 16, kNone, 0.01},
    {0x01, "temperature", 2, "temperature", "degC", 0, 16, kNone, 0.1, kColdest},
    {0x02, "rotation_speed", 2, "speed", "rpm", 0, 16, kNone},
    // Signed, because a genuine sensor with an open input sends FFFF and FFFE.
    {0x03, "external_voltage", 2, "voltage", "V", 0, 16, kSigned, 0.01, 0, -0x8000},
    {0x04, "average_cell_voltage", 2, "voltage", "V", 0, 16, kNone, 0.01},
    {0x05, "battery_current", 2, "current", "A", 0, 16, kNone, 0.01},
    // Percent or mAh, as the sender chose.
    {0x06, "fuel", 2, "fuel", "", 0, 16, kNone},
    {0x07, "engine_speed", 2, "speed", "rpm", 0, 16, kNone},
    {0x08, "heading", 2, "heading", "deg", 0, 16, kNone},
    {0x09, "climb_rate", 2, "speed", "m/s", 0, 16, kSigned, 0.01},
    {0x0A, "course_over_ground", 2, "course", "deg", 0, 16, kNone, 0.01, 0, 0xFFFF},
    {0x0B, "gps_status", 2, "fix", "", 0, 8, kNone},
    {0x0B, "gps_status", 2, "satellites", "", 8, 8, kNone},
    {0x0C, "acceleration_x", 2, "acceleration", "m/s^2", 0, 16, kSigned, 0.01},
    {0x0D, "acceleration_y", 2, "acceleration", "m/s^2", 0, 16, kSigned, 0.01},
    {0x0E, "acceleration_z", 2, "acceleration", "m/s^2", 0, 16, kSigned, 0.01},
    {0x0F, "roll", 2, "angle", "deg", 0, 16, kSigned, 0.01},
    {0x10, "pitch", 2, "angle", "deg", 0, 16, kSigned, 0.01},
    {0x11, "yaw", 2, "angle", "deg", 0, 16, kTurn, 0.01},
    {0x12, "vertical_speed", 2, "speed", "m/s", 0, 16, kSigned, 0.01},
    {0x13, "ground_speed", 2, "speed", "m/s", 0, 16, kNone, 0.01},
    {0x14, "distance_from_home", 2, "distance", "m", 0, 16, kNone},
    {0x15, "armed", 2, "armed", "", 0, 16, kNone},
    {0x16, "flight_mode", 2, "mode", "", 0, 16, kNone, 1, 0, 255},
    {0x41, "pressure", 4, "pressure", "Pa", 0, 19, kNone},
    {0x41, "pressure", 4, "temperature", "degC", 19, 13, kNone, 0.1, kColdest},
    {0x7C, "odometer_1", 2, "distance", "km", 0, 16, kNone, 0.1},
    {0x7D, "odometer_2", 2, "distance", "km", 0, 16, kNone, 0.1},
    {0x7E, "speed", 2, "speed", "km/h", 0, 16, kNone, 0.1},
    {0x7F, "transmitter_voltage", 2, "voltage", "V", 0, 16, kNone, 0.01},
    {0x80, "latitude", 4, "latitude", "deg", 0, 32, kSigned, 1e-7},
    {0x81, "longitude", 4, "longitude", "deg", 0, 32, kSigned, 1e-7},
    {0x82, "gps_altitude", 4, "altitude", "m", 0, 32, kSigned, 0.01},
    {0x83, "altitude", 4, "altitude", "m", 0, 32, kSigned, 0.01},
    {0x84, "maximum_altitude", 4, "altitude", "m", 0, 32, kSigned, 0.01},
    {0x85, "user_1", 4, "value", "", 0, 32, kSigned},
    {0x86, "user_2", 4, "value", "", 0, 32, kSigned},
    {0x87, "user_3", 4, "value", "", 0, 32, kSigned},
    {0x88, "user_4", 4, "value", "", 0, 32, kSigned},
    {0x89, "user_5", 4, "value", "", 0, 32, kSigned},
    {0x8A, "user_6", 4, "value", "", 0, 32, kSigned},
    // The next two and GPS_FULL need a modified receiver.
    {0xEF, "acceleration_full", 12, "acceleration_x", "m/s^2", 0, 16, kSigned, 0.01},
    {0xEF, "acceleration_full", 12, "acceleration_y", "m/s^2", 16, 16, kSigned, 0.01},
    {0xEF, "acceleration_full", 12, "acceleration_z", "m/s^2", 32, 16, kSigned, 0.01},
    {0xEF, "acceleration_full", 12, "roll", "deg", 48, 16, kSigned, 0.01},
    {0xEF, "acceleration_full", 12, "pitch", "deg", 64, 16, kSigned, 0.01},
    {0xEF, "acceleration_full", 12, "yaw", "deg", 80, 16, kTurn, 0.01},
    {0xF0, "voltage_full", 10, "external_voltage", "V", 0, 16, kNone, 0.01},
    {0xF0, "voltage_full", 10, "average_cell_voltage", "V", 16, 16, kNone, 0.01},
    {0xF0, "voltage_full", 10, "battery_current", "A", 32, 16, kNone, 0.01},
    {0xF0, "voltage_full", 10, "fuel", "", 48, 16, kNone},
    {0xF0, "voltage_full", 10, "engine_speed", "rpm", 64, 16, kNone},
    {0xF7, "signal", 2, "signal", "%", 0, 16, kNone},
    {0xF8, "snr_afhds3", 2, "ratio", "dB", 0, 16, kSigned, 0.1},
    {0xF9, "altitude_flysky", 2, "altitude", "m", 0, 16, kSigned},
    {0xFA, "snr", 2, "ratio", "dB", 0, 16, kNone},
    {0xFB, "noise", 2, "power", "dBm", 0, 16, kNone, -1},
    {0xFC, "rssi", 2, "power", "dBm", 0, 16, kNone, -1},
    {0xFD, "gps_full", 14, "fix", "", 0, 8, kNone},
    {0xFD, "gps_full", 14, "satellites", "", 8, 8, kNone},
    {0xFD, "gps_full", 14, "latitude", "deg", 16, 32, kSigned, 1e-7},
    {0xFD, "gps_full", 14, "longitude", "deg", 48, 32, kSigned, 1e-7},
    {0xFD, "gps_full", 14, "altitude", "m", 80, 32, kSigned, 0.01},
    {0xFE, "error_rate", 2, "rate", "%", 0, 16, kNone},
};

constexpr Row kBetaflight[] = {
    // The throttle command, 1000 to 2000.
    {0x02, "rotation_speed", 2, "throttle", "us", 0, 16, kSigned},
    {0x03, "external_voltage", 2, "voltage", "V", 0, 16, kNone, 0.01},
    {0x05, "battery_current", 2, "current", "A", 0, 16, kSigned, 0.01},
    // The throttle command while armed, else the battery's capacity in mAh.
    {0x07, "throttle_or_capacity", 2, "value", "", 0, 16, kNone},
    // Sent ten times too large, so it wraps at 65.5 degrees.
    {0x0A, "course_over_ground", 2, "course", "deg", 0, 16, kNone, 0.001},
    {0x0C, "acceleration_x", 2, "acceleration", "m/s^2", 0, 16, kSigned, kMilliGravity},
    {0x0D, "acceleration_y", 2, "acceleration", "m/s^2", 0, 16, kSigned, kMilliGravity},
    {0x0E, "acceleration_z", 2, "acceleration", "m/s^2", 0, 16, kSigned, kMilliGravity},
    // The distance from home.
    {0x7C, "odometer_1", 2, "distance", "m", 0, 16, kNone},
    {0x7D, "odometer_2", 2, "distance", "m", 0, 16, kNone},
    // Betaflight fills these with the functions of the single types.
    {0xEF, "acceleration_full", 12, "acceleration_x", "m/s^2", 0, 16, kSigned, kMilliGravity},
    {0xEF, "acceleration_full", 12, "acceleration_y", "m/s^2", 16, 16, kSigned, kMilliGravity},
    {0xEF, "acceleration_full", 12, "acceleration_z", "m/s^2", 32, 16, kSigned, kMilliGravity},
    {0xEF, "acceleration_full", 12, "roll", "deg", 48, 16, kSigned, 0.01},
    {0xEF, "acceleration_full", 12, "pitch", "deg", 64, 16, kSigned, 0.01},
    {0xEF, "acceleration_full", 12, "yaw", "deg", 80, 16, kTurn, 0.01},
    {0xF0, "voltage_full", 10, "external_voltage", "V", 0, 16, kNone, 0.01},
    {0xF0, "voltage_full", 10, "average_cell_voltage", "V", 16, 16, kNone, 0.01},
    {0xF0, "voltage_full", 10, "battery_current", "A", 32, 16, kSigned, 0.01},
    {0xF0, "voltage_full", 10, "fuel", "", 48, 16, kNone},
    {0xF0, "voltage_full", 10, "throttle_or_capacity", "", 64, 16, kNone},
};

constexpr Row kInav[] = {
    {0x0B, "gps_status", 2, "satellites", "", 0, 8, kNone},
    {0x0B, "gps_status", 2, "fix", "", 8, 8, kNone},
    {0x41, "pressure", 2, "pressure", "Pa", 0, 16, kNone, 10},
};

constexpr Row kArdupilot[] = {
    {0x03, "external_voltage", 2, "voltage", "V", 0, 16, kNone, 0.01},
    {0x0C, "acceleration_x", 2, "acceleration", "m/s^2", 0, 16, kSigned, 0.001},
    {0x0D, "acceleration_y", 2, "acceleration", "m/s^2", 0, 16, kSigned, 0.001},
    {0x0E, "acceleration_z", 2, "acceleration", "m/s^2", 0, 16, kSigned, 0.001},
    {0x7E, "speed", 2, "speed", "m/s", 0, 16, kNone},
};

constexpr Row kEdgetx[] = {
    {0x04, "gyroscope", 2, "rate", "deg/s", 0, 16, kSigned, 0.1, 0, -0x8000},
    {0x7C, "odometer_1", 2, "distance", "m", 0, 16, kNone, 0.01},
    {0x7D, "odometer_2", 2, "distance", "m", 0, 16, kNone, 0.01},
    {0x7E, "speed", 2, "speed", "km/h", 0, 16, kNone, 0.01},
};

/// The older of INAV's two sets of ids.
constexpr Row kFlyplus[] = {
    {0x04, "heading", 2, "heading", "deg", 0, 16, kNone},
    {0x06, "climb_rate", 2, "speed", "m/s", 0, 16, kSigned, 0.01},
    {0x07, "acceleration_z", 2, "acceleration", "m/s^2", 0, 16, kSigned, 0.01},
    {0x08, "acceleration_y", 2, "acceleration", "m/s^2", 0, 16, kSigned, 0.01},
    {0x09, "acceleration_x", 2, "acceleration", "m/s^2", 0, 16, kSigned, 0.01},
    {0x0A, "vertical_speed", 2, "speed", "m/s", 0, 16, kSigned, 0.01},
    {0x0B, "ground_speed", 2, "speed", "m/s", 0, 16, kNone, 0.01},
    {0x0C, "distance_from_home", 2, "distance", "m", 0, 16, kNone},
    {0x0D, "armed", 2, "armed", "", 0, 16, kNone},
    {0x0E, "flight_mode", 2, "mode", "", 0, 16, kNone, 1, 0, 255},
    {0x41, "pressure", 2, "pressure", "Pa", 0, 16, kNone, 10},
    {0x80, "course_over_ground", 2, "course", "deg", 0, 16, kNone, 0.01, 0, 0xFFFF},
    {0x81, "gps_status", 2, "satellites", "", 0, 8, kNone},
    {0x81, "gps_status", 2, "fix", "", 8, 8, kNone},
    {0x82, "longitude", 4, "longitude", "deg", 0, 32, kSigned, 1e-7},
    {0x83, "latitude", 4, "latitude", "deg", 0, 32, kSigned, 1e-7},
    {0x84, "altitude", 2, "altitude", "m", 0, 16, kSigned, 0.01},
};

std::span<const Row> rows_of(SensorDialect dialect) {
    switch (dialect) {
        case SensorDialect::flysky:
            return {};
        case SensorDialect::betaflight:
            return kBetaflight;
        case SensorDialect::inav:
            return kInav;
        case SensorDialect::ardupilot:
            return kArdupilot;
        case SensorDialect::edgetx:
            return kEdgetx;
        case SensorDialect::flyplus:
            return kFlyplus;
    }
    return {};
}

SensorField field_of(const Row& row) {
    return {.name = std::string(row.field),
            .unit = std::string(row.unit),
            .first_bit = row.first_bit,
            .bits = row.bits,
            .is_signed = row.sign != kNone,
            .scale = row.scale,
            .offset = row.offset,
            .not_available = row.not_available,
            .least = row.sign == kTurn ? std::optional(kLeastOfTurn) : std::nullopt};
}

/// Adds the types whose id and name are still free.
void add_types(std::vector<SensorType>& types, std::span<const Row> rows) {
    for (std::size_t first = 0; first < rows.size();) {
        const Row& row = rows[first];
        SensorType type{
            .name = std::string(row.type), .id = row.id, .size = row.size, .fields = {}};
        for (; first < rows.size() && rows[first].id == row.id; ++first) {
            type.fields.push_back(field_of(rows[first]));
        }
        const bool taken = std::ranges::any_of(types, [&](const SensorType& other) {
            return other.id == type.id || other.name == type.name;
        });
        if (!taken) {
            types.push_back(std::move(type));
        }
    }
}

}  // namespace

SensorTypes::SensorTypes(SensorDialect dialect, std::vector<SensorType> own)
    : types_(std::move(own)) {
    add_types(types_, rows_of(dialect));
    add_types(types_, kFlysky);
}

const SensorType* SensorTypes::find(std::uint8_t id) const {
    const auto found = std::ranges::find(types_, id, &SensorType::id);
    return found == types_.end() ? nullptr : &*found;
}

const SensorType* SensorTypes::find(std::string_view name) const {
    const auto found = std::ranges::find(types_, name, &SensorType::name);
    return found == types_.end() ? nullptr : &*found;
}

SensorType with_size(const SensorType& type, std::uint8_t size) {
    constexpr std::uint8_t kMostNumber = 8;
    if (size == type.size || size == 0 || size > kMostNumber || type.fields.empty()) {
        return type;
    }
    SensorType plain = type;
    plain.size = size;
    plain.fields.resize(1);
    SensorField& field = plain.fields.front();
    field.first_bit = 0;
    field.bits = size * 8U;
    field.not_available.reset();
    field.least.reset();
    return plain;
}

}  // namespace tribus
