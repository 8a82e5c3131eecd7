#include "transports/codecs/crsf/telemetry_reader.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "transports/codecs/crsf/telemetry_numbers.h"
#include "transports/codecs/crsf/wire.h"

namespace tribus {
namespace {

/// Calls `visit` for each message until it returns true.
template <class Visit>
void for_each_message(Visit visit) {
    if (!std::ranges::any_of(kTelemetryMessages, visit)) {
        std::ranges::any_of(kReadMessages, visit);
    }
}

std::size_t readings_of(const TelemetryMessage& message) {
    return message.numbers.size() * message.most;
}

/// TBS's text: 0 is -1000 m in steps of 0.1 m up to 2276.7 m; from there on whole metres.
double packed_altitude(std::uint64_t bits) {
    constexpr std::uint64_t kMetres = 0x8000;
    return (bits & kMetres) != 0 ? static_cast<double>(bits & (kMetres - 1))
                                 : (static_cast<double>(bits) - 10'000) / 10;
}

/// TBS's text: (exp(|byte| * 0.026) - 1) * 1 m/s, with the sign of the byte.
double packed_climb(double packed) {
    constexpr double kRange = 0.026;
    return std::copysign(std::expm1(std::abs(packed) * kRange), packed);
}

double number_at(std::span<const std::uint8_t> payload, std::size_t at,
                 const TelemetryNumber& number) {
    std::uint64_t bits = 0;
    for (std::size_t byte = 0; byte < number.bytes; ++byte) {
        bits = bits << 8U | payload[at + byte];
    }
    const double range = std::ldexp(1.0, static_cast<int>(8 * number.bytes));
    auto raw = static_cast<double>(bits);
    raw -= number.is_signed && raw >= range / 2 ? range : 0;
    switch (number.forming) {
        case TelemetryForming::altitude:
            return packed_altitude(bits);
        case TelemetryForming::climb:
            return packed_climb(raw);
        case TelemetryForming::straight:
        case TelemetryForming::turn:
            break;
    }
    return (raw - number.offset) / number.scale;
}

/// Reads the numbers from `at` on, as often as they fit. Returns how many there were.
std::size_t read_numbers(const TelemetryMessage& message, std::span<const std::uint8_t> payload,
                         std::size_t at, std::span<ValueReading> readings) {
    std::size_t count = 0;
    for (std::size_t turn = 0; turn < message.most; ++turn) {
        for (const TelemetryNumber& number : message.numbers) {
            if (at + number.bytes > payload.size()) {
                return count;
            }
            readings[count++] = {ValueReading::State::number, number_at(payload, at, number)};
            at += number.bytes;
        }
    }
    return count;
}

std::string name_of_reading(const TelemetryMessage& message, std::size_t index) {
    std::string key(message.key);
    switch (message.form) {
        case TelemetryForm::table:
            return key + "." + std::string(message.numbers[index].key);
        case TelemetryForm::numbered:
            return key + "." + std::to_string(index + 1);
        case TelemetryForm::single:
            break;
    }
    return key;
}

}  // namespace

CrsfTelemetryReader::CrsfTelemetryReader() {
    for_each_message([this](const TelemetryMessage& message) {
        for (std::size_t index = 0; index < readings_of(message); ++index) {
            const std::size_t number = index % message.numbers.size();
            values_.push_back(
                {name_of_reading(message, index), std::string(message.numbers[number].unit)});
        }
        return false;
    });
    frames_.readings.resize(values_.size());
}

bool CrsfTelemetryReader::next(std::span<const std::uint8_t>& bytes, Instant received,
                               std::span<ValueReading> readings) {
    DecodedFrame frame;
    if (!frames_.next(bytes, received, frame)) {
        return false;
    }
    std::ranges::copy(frames_.readings, readings.begin());
    return true;
}

bool CrsfTelemetryReader::Frames::read(std::span<const std::uint8_t> frame,
                                       ChannelFrame& /*channels*/) {
    const auto payload = payload_of(frame);
    std::ranges::fill(readings, ValueReading{});
    std::size_t first = 0;
    bool complete = false;
    for_each_message([&](const TelemetryMessage& message) {
        const auto own = std::span(readings).subspan(first, readings_of(message));
        first += own.size();
        if (frame[crsf_wire::kTypeAt] != message.type) {
            return false;
        }
        const bool numbered = message.form == TelemetryForm::numbered;
        const bool known = !numbered || (!payload.empty() && payload[0] == kTelemetrySource);
        const std::size_t least = message.least.value_or(message.numbers.size());
        complete = known && read_numbers(message, payload, numbered ? 1 : 0, own) >= least;
        return true;
    });
    return complete;
}

}  // namespace tribus
