#include "transports/codecs/mavlink/telemetry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>

namespace tribus {

using namespace mavlink_wire;

namespace {

enum class Form : std::uint8_t { u8, i8, u16, i16, u32, i32, f32 };

/// A number of a message: raw / scale. `unknown` is the raw number that means "not known".
struct MavlinkNumber {
    std::string_view name;
    std::string_view unit;
    std::size_t at = 0;
    Form form = Form::u16;
    double scale = 1;
    std::optional<double> unknown{};
};

constexpr double kNoWord = 0xFFFF;
constexpr double kRadiansADegree = std::numbers::pi / 180;

constexpr std::array kSystemNumbers{
    MavlinkNumber{"system.load", "%", 12, Form::u16, 10},
    MavlinkNumber{"system.voltage", "V", 14, Form::u16, 1000, kNoWord},
    MavlinkNumber{"system.current", "A", 16, Form::i16, 100, -1},
    MavlinkNumber{"system.remaining", "%", 30, Form::i8, 1, -1}};
constexpr std::array kGpsRawNumbers{
    MavlinkNumber{"gps.fix", "", 28, Form::u8},
    MavlinkNumber{"gps.latitude", "deg", 8, Form::i32, 1e7},
    MavlinkNumber{"gps.longitude", "deg", 12, Form::i32, 1e7},
    MavlinkNumber{"gps.altitude", "m", 16, Form::i32, 1000},
    MavlinkNumber{"gps.speed", "m/s", 24, Form::u16, 100, kNoWord},
    MavlinkNumber{"gps.heading", "deg", 26, Form::u16, 100, kNoWord},
    MavlinkNumber{"gps.satellites", "", 29, Form::u8, 1, 255}};
constexpr std::array kAttitudeAngles{
    MavlinkNumber{"attitude.roll", "deg", 4, Form::f32, kRadiansADegree},
    MavlinkNumber{"attitude.pitch", "deg", 8, Form::f32, kRadiansADegree},
    MavlinkNumber{"attitude.yaw", "deg", 12, Form::f32, kRadiansADegree}};
constexpr std::array kHudNumbers{MavlinkNumber{"hud.airspeed", "m/s", 0, Form::f32},
                                 MavlinkNumber{"hud.groundspeed", "m/s", 4, Form::f32},
                                 MavlinkNumber{"hud.altitude", "m", 8, Form::f32},
                                 MavlinkNumber{"hud.climb", "m/s", 12, Form::f32},
                                 MavlinkNumber{"hud.heading", "deg", 16, Form::i16},
                                 MavlinkNumber{"hud.throttle", "%", 18, Form::u16}};
constexpr std::array kRadioNumbers{MavlinkNumber{"radio.rssi", "", 4, Form::u8, 1, 255},
                                   MavlinkNumber{"radio.remote_rssi", "", 5, Form::u8, 1, 255},
                                   MavlinkNumber{"radio.noise", "", 7, Form::u8, 1, 255},
                                   MavlinkNumber{"radio.remote_noise", "", 8, Form::u8, 1, 255}};
/// The voltage is the sum of the cells.
constexpr std::array kBatteryValues{
    MavlinkNumber{"battery.voltage", "V", 10, Form::u16, 1000, kNoWord},
    MavlinkNumber{"battery.current", "A", 30, Form::i16, 100, -1},
    MavlinkNumber{"battery.consumed", "mAh", 0, Form::i32, 1, -1},
    MavlinkNumber{"battery.remaining", "%", 35, Form::i8, 1, -1},
    MavlinkNumber{"battery.temperature", "degC", 8, Form::i16, 100, 0x7FFF}};
constexpr std::size_t kBatteryCells = 10;
/// Cells 11 to 14, an extension: a message without it has zeros there.
constexpr std::size_t kMoreCellsAt = 41;
constexpr std::size_t kMoreBatteryCells = 4;
constexpr std::size_t kBatteryIdAt = 32;
constexpr std::size_t kFixAt = 28;
/// GPS_FIX_TYPE_2D_FIX.
constexpr unsigned kLeastFix = 2;

struct ValueMessage {
    std::uint32_t id = 0;
    std::span<const MavlinkNumber> numbers;
};
constexpr std::array kValueMessagesRead{
    ValueMessage{kSysStatus.id, kSystemNumbers},  ValueMessage{kGpsRawInt.id, kGpsRawNumbers},
    ValueMessage{kAttitude.id, kAttitudeAngles},  ValueMessage{kVfrHud.id, kHudNumbers},
    ValueMessage{kRadioStatus.id, kRadioNumbers}, ValueMessage{kBatteryStatus.id, kBatteryValues}};

using ValuePayload = std::span<const std::uint8_t>;

double raw_number(ValuePayload payload, std::size_t at, Form form) {
    switch (form) {
        case Form::u8:
            return payload[at];
        case Form::i8:
            return static_cast<std::int8_t>(payload[at]);
        case Form::u16:
            return field_at<std::uint16_t>(payload, at);
        case Form::i16:
            return field_at<std::int16_t>(payload, at);
        case Form::u32:
            return field_at<std::uint32_t>(payload, at);
        case Form::i32:
            return field_at<std::int32_t>(payload, at);
        case Form::f32:
            return field_at<float>(payload, at);
    }
    return 0;
}

ValueReading reading_of(const MavlinkNumber& number, double raw) {
    if (!std::isfinite(raw) || (number.unknown && raw == *number.unknown)) {
        return {.state = ValueReading::State::not_available};
    }
    return {ValueReading::State::number, raw / number.scale};
}

/// Of the first ten cells, those that are not there are 65535; of the other four, 0 or, from some
/// autopilots, 65535. An autopilot that knows the whole voltage only writes it to the first cell,
/// and to the next ones what exceeds a word.
ValueReading battery_voltage(const MavlinkNumber& number, ValuePayload payload) {
    double sum = 0;
    bool known = false;
    for (std::size_t cell = 0; cell < kBatteryCells; ++cell) {
        const double raw = raw_number(payload, number.at + 2 * cell, number.form);
        known = known || raw != kNoWord;
        sum += raw != kNoWord ? raw : 0;
    }
    for (std::size_t cell = 0; cell < kMoreBatteryCells; ++cell) {
        const double raw = raw_number(payload, kMoreCellsAt + 2 * cell, number.form);
        const bool there = raw != 0 && raw != kNoWord;
        known = known || there;
        sum += there ? raw : 0;
    }
    return reading_of(number, known ? sum : kNoWord);
}

/// A position without a fix is none.
bool lacks_fix(const MavlinkNumber& number, ValuePayload payload) {
    return payload[kFixAt] < kLeastFix && number.form == Form::i32;
}

ValueReading read_number(const ValueMessage& message, const MavlinkNumber& number,
                         ValuePayload payload) {
    if (message.id == kBatteryStatus.id && number.at == kBatteryValues[0].at) {
        return battery_voltage(number, payload);
    }
    if (message.id == kGpsRawInt.id && lacks_fix(number, payload)) {
        return {.state = ValueReading::State::not_available};
    }
    return reading_of(number, raw_number(payload, number.at, number.form));
}

}  // namespace

MavlinkTelemetryReader::MavlinkTelemetryReader(const std::optional<SecretKey>& key)
    : messages_(key) {
    for (const ValueMessage& message : kValueMessagesRead) {
        for (const MavlinkNumber& number : message.numbers) {
            values_.push_back({std::string(number.name), std::string(number.unit)});
        }
    }
    messages_.readings.resize(values_.size());
}

bool MavlinkTelemetryReader::next(std::span<const std::uint8_t>& bytes, Instant received,
                                  std::span<ValueReading> readings) {
    DecodedFrame frame;
    if (!messages_.next(bytes, received, frame)) {
        return false;
    }
    std::ranges::copy(messages_.readings, readings.begin());
    return true;
}

/// The radio at the end of the link sends for itself; of an autopilot only its main component
/// counts, whatever else has its system id.
bool MavlinkTelemetryReader::Messages::is_from_autopilot(const MavlinkMessage& message,
                                                         Instant received) {
    const bool of_radio = message.id == kRadioStatus.id;
    if (!of_radio && message.component != kAutopilotComponent) {
        return false;
    }
    if (!(of_radio ? radio_ : autopilot_).sent(message, 0, received)) {
        refuse_sender();
        return false;
    }
    return message.id != kBatteryStatus.id || message.payload[kBatteryIdAt] == 0;
}

bool MavlinkTelemetryReader::Messages::take(const MavlinkMessage& message, ChannelFrame& channels) {
    const bool has_values =
        std::ranges::count(kValueMessagesRead, message.id, &ValueMessage::id) > 0;
    if (!has_values || !is_from_autopilot(message, channels.received)) {
        return false;
    }
    std::ranges::fill(readings, ValueReading{});
    std::size_t place = 0;
    for (const ValueMessage& candidate : kValueMessagesRead) {
        for (const MavlinkNumber& number : candidate.numbers) {
            if (candidate.id == message.id) {
                readings[place] = read_number(candidate, number, message.payload);
            }
            ++place;
        }
    }
    return true;
}

}  // namespace tribus
