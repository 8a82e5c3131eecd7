#include "transports/codecs/dbc/channel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include <fmt/format.h>

namespace tribus {
namespace {

/// Status codes of J1939 (docs/protocols/can.md, "J1939 joysticks").
enum Status : std::uint64_t { kNo = 0, kYes = 1, kError = 2, kNotAvailable = 3 };

using Range = std::optional<std::array<double, 2>>;

double along(double at, const std::array<double, 2>& from, const std::array<double, 2>& to) {
    return to[0] + (at - from[0]) * (to[1] - to[0]) / (from[1] - from[0]);
}

/// The state of a direction signal, or nothing for "error" and "not available".
std::optional<bool> read_status(const std::optional<DbcLayout>& layout,
                                std::span<const std::uint8_t> data) {
    const std::uint64_t bits = layout ? layout->raw_bits(data) : kNo;
    return bits <= kYes ? std::optional(bits == kYes) : std::nullopt;
}

/// The magnitude with its sign. Nothing if the direction signals contradict each other: two
/// directions, a direction in neutral, or no direction with the stick out of neutral.
std::optional<double> read_signed(const DbcChannel& channel, double magnitude,
                                  std::span<const std::uint8_t> data) {
    const auto negative = read_status(channel.negative, data);
    const auto positive = read_status(channel.positive, data);
    const auto neutral = read_status(channel.neutral, data);
    if (!negative || !positive || !neutral || int{*negative} + *positive + *neutral > 1) {
        return std::nullopt;
    }
    const bool undirected = channel.positive && !*negative && !*positive && !*neutral;
    if (undirected && magnitude != 0) {
        return std::nullopt;
    }
    if (*neutral) {
        return 0.0;
    }
    return *negative ? -magnitude : magnitude;
}

/// Whether a value is within the range of the file, apart from rounding of the limits.
bool in_range(const DbcLayout& layout, const Range& range, std::uint64_t bits, double value) {
    if (!range) {
        return true;
    }
    const double allowed = std::clamp(value, (*range)[0], (*range)[1]);
    return allowed == value || layout.bits_from_physical(allowed) == bits;
}

void write_status(const std::optional<DbcLayout>& layout, std::uint64_t status,
                  std::span<std::uint8_t> data) {
    if (layout) {
        layout->set_raw_bits(data, status);
    }
}

void write_code(const DbcChannel& channel, std::uint64_t code, std::span<std::uint8_t> data) {
    const std::uint64_t status = code == channel.error ? kError : kNotAvailable;
    channel.layout.set_raw_bits(data, code);
    write_status(channel.negative, status, data);
    write_status(channel.positive, status, data);
    write_status(channel.neutral, status, data);
}

bool is_code(const DbcChannel& channel, std::uint64_t bits) {
    return bits == channel.error || bits == channel.not_available ||
           bits == channel.usual_not_available;
}

/// The bits of a value. If they would be a code, such as "error", the bits of the nearest value
/// that is no code; never from the other end of the signal's range, which would be full travel in
/// the opposite direction. `is_code` tells whether bits are a code.
template <class IsCode>
std::uint64_t value_bits(const DbcLayout& layout, const Range& range, IsCode is_code,
                         double value) {
    if (range) {
        value = std::clamp(value, (*range)[0], (*range)[1]);
    }
    const std::uint64_t wanted = layout.bits_from_physical(value);
    if (!is_code(wanted)) {
        return wanted;
    }
    std::uint64_t nearest = wanted;
    double least_distance = std::numeric_limits<double>::infinity();
    const auto raw = static_cast<std::uint64_t>(layout.raw_value(wanted));
    // Two codes may be adjacent.
    for (const std::uint64_t near : {raw - 1, raw + 1, raw - 2, raw + 2}) {
        const auto bits = layout.bits_from_raw(static_cast<std::int64_t>(near));
        if (!bits || is_code(*bits)) {
            continue;
        }
        const double physical = layout.physical(*bits);
        const double distance = std::abs(physical - value);
        if (distance < least_distance && in_range(layout, range, *bits, physical)) {
            nearest = *bits;
            least_distance = distance;
        }
    }
    return nearest;
}

}  // namespace

std::optional<Pulse> read_dbc_channel(const DbcChannel& channel,
                                      std::span<const std::uint8_t> data) {
    const std::uint64_t bits = channel.layout.raw_bits(data);
    if (is_code(channel, bits)) {
        return std::nullopt;
    }
    std::optional<double> value = channel.layout.physical(bits);
    if (!std::isfinite(*value) || !in_range(channel.layout, channel.range, bits, *value)) {
        return std::nullopt;
    }
    if (channel.negative) {
        value = read_signed(channel, *value, data);
    }
    if (!value) {
        return std::nullopt;
    }
    return Pulse::from_fractional_microseconds(along(*value, channel.value, channel.microseconds));
}

std::size_t write_dbc_absence(const DbcChannel& channel, std::uint64_t bits, std::span<char> text) {
    const double value = channel.layout.physical(bits);
    const auto written = [&text](auto result) {
        return std::min<std::size_t>(result.size, text.size());
    };
    if (bits == channel.error) {
        return written(fmt::format_to_n(text.data(), text.size(), "its code for \"error\""));
    }
    if (bits == channel.not_available || bits == channel.usual_not_available) {
        return written(
            fmt::format_to_n(text.data(), text.size(), "its code for \"not available\""));
    }
    if (!std::isfinite(value)) {
        return written(fmt::format_to_n(text.data(), text.size(), "{} is no number", value));
    }
    if (!in_range(channel.layout, channel.range, bits, value)) {
        return written(fmt::format_to_n(text.data(), text.size(), "{} is outside of [{}|{}]", value,
                                        (*channel.range)[0], (*channel.range)[1]));
    }
    return written(fmt::format_to_n(
        text.data(), text.size(), "its direction signals contradict each other or have no value"));
}

void write_dbc_channel(const DbcChannel& channel, std::optional<Pulse> pulse, bool failsafe,
                       std::span<std::uint8_t> data) {
    const auto code = failsafe && channel.error ? channel.error
                      : channel.not_available   ? channel.not_available
                                                : channel.error;
    if (code && (failsafe || !pulse)) {
        write_code(channel, *code, data);
        return;
    }
    const double microseconds = pulse.value_or(kCentrePulse).microseconds();
    const double value = along(microseconds, channel.microseconds, channel.value);
    const std::uint64_t bits = value_bits(
        channel.layout, channel.range, [&](std::uint64_t at) { return is_code(channel, at); },
        channel.negative ? std::abs(value) : value);
    channel.layout.set_raw_bits(data, bits);
    const bool centred = channel.layout.physical(bits) == 0;
    write_status(channel.neutral, centred ? kYes : kNo, data);
    write_status(channel.negative, !centred && value < 0 ? kYes : kNo, data);
    write_status(channel.positive, !centred && value > 0 ? kYes : kNo, data);
}

namespace {

/// Whether the number is negative and the nearest that the signal can carry is not.
bool lacks_sign(const DbcValue& value, double number) {
    if (number >= 0) {
        return false;
    }
    const double limited =
        value.range ? std::clamp(number, (*value.range)[0], (*value.range)[1]) : number;
    const double sent = value.layout.physical(value.layout.bits_from_physical(limited));
    const double step = std::abs(value.layout.physical(1) - value.layout.physical(0));
    return sent >= 0 && sent - number > step / 2;
}

}  // namespace

bool write_dbc_value(const DbcValue& value, std::optional<double> number,
                     std::span<std::uint8_t> data) {
    if (!number || std::isnan(*number) || lacks_sign(value, *number)) {
        if (value.not_available) {
            value.layout.set_raw_bits(data, *value.not_available);
        }
        return value.not_available.has_value();
    }
    std::uint64_t bits = value_bits(
        value.layout, value.range, [&](std::uint64_t at) { return at == value.not_available; },
        *number);
    if (value.most_bits && bits > *value.most_bits) {
        bits = *value.most_bits == value.not_available ? *value.most_bits - 1 : *value.most_bits;
    }
    value.layout.set_raw_bits(data, bits);
    return true;
}

}  // namespace tribus
