#include "transports/codecs/exbus/telemetry.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "transports/codecs/crc.h"
#include "transports/codecs/exbus/wire.h"

namespace tribus {

namespace {

// docs/protocols/exbus.md, "Telemetry": the message inside the data of an answer.
constexpr std::uint8_t kExMessage = 0x9F;
constexpr std::uint8_t kExNumbers = 0x40;
constexpr std::uint8_t kExText = 0x00;
constexpr std::uint16_t kExMaker = 0xA400;
constexpr std::size_t kExKindAndLengthAt = kExBusDataAt + 1;
constexpr std::size_t kExMakerAt = kExBusDataAt + 2;
constexpr std::size_t kExDeviceAt = kExBusDataAt + 4;
constexpr std::size_t kExReservedAt = kExBusDataAt + 6;
constexpr std::size_t kExContentAt = kExBusDataAt + 7;
/// Betaflight's limit, below that of others.
constexpr std::size_t kExMostData = 26;
constexpr std::size_t kExContentEnd = kExBusDataAt + kExMostData - 1;
using ExMessageCrc = Crc<std::uint8_t, 0x07>;

constexpr std::uint8_t kExDecimalType = 4;
constexpr std::uint8_t kExPositionType = 9;
constexpr std::size_t kExDecimalBytes = 1 + 3;
constexpr std::size_t kExPositionBytes = 1 + 4;
constexpr std::int64_t kExMostDecimal = 2097151;

/// 64 bytes at 125,000 baud. A frame does not take longer, so it ended.
constexpr Duration kExLongestFrameTime = std::chrono::microseconds(5120);

static_assert(2 + ExBusSensor::kMostLabel + ExBusSensor::kMostUnit <= kExContentEnd - kExContentAt);
static_assert(2 + ExBusDevice::kMostName <= kExContentEnd - kExContentAt);

void put_ex_word(std::span<std::uint8_t> wire, std::size_t at, std::uint16_t word) {
    wire[at] = static_cast<std::uint8_t>(word);
    wire[at + 1] = static_cast<std::uint8_t>(word >> 8U);
}

/// The number with as many decimals as fit, with sign and decimals in the upper three bits.
std::uint32_t decimal_bits(double value, int decimals) {
    double scaled = value * std::pow(10, decimals);
    while (decimals > 0 && std::abs(scaled) > static_cast<double>(kExMostDecimal)) {
        scaled /= 10;
        --decimals;
    }
    const auto most = static_cast<double>(kExMostDecimal);
    const auto whole = static_cast<std::int32_t>(std::lround(std::clamp(scaled, -most, most)));
    constexpr unsigned kNumberBits = 21;
    return (static_cast<std::uint32_t>(whole) & ((1U << kNumberBits) - 1)) |
           static_cast<std::uint32_t>(decimals) << kNumberBits | (whole < 0 ? 1U << 23U : 0U);
}

/// Degrees as thousandths of a minute, whole degrees, and which axis and side.
std::uint32_t position_bits(double degrees, bool is_longitude) {
    constexpr std::uint32_t kThousandthsOfADegree = 60'000;
    const double most = is_longitude ? 180 : 90;
    const auto thousandths = static_cast<std::uint32_t>(
        std::lround(std::min(std::abs(degrees), most) * kThousandthsOfADegree));
    return thousandths % kThousandthsOfADegree | (thousandths / kThousandthsOfADegree) << 16U |
           (is_longitude ? 1U << 29U : 0U) | (degrees < 0 ? 1U << 30U : 0U);
}

/// Degrees as the transmitter shows them: it knows Latin-1.
std::string shown_unit(std::string_view unit) {
    return unit == "degC"                         ? "\xB0"
                                                    "C"
           : unit == "deg"                        ? "\xB0"
           : unit.size() > ExBusSensor::kMostUnit ? std::string()
                                                  : std::string(unit);
}

/// Fills in all but kind and content, which end at `end`. Returns the length of the frame.
std::size_t finish_answer(std::span<std::uint8_t> wire, std::uint8_t packet, std::uint16_t device,
                          std::size_t end) {
    wire[0] = kExBusAnswer;
    wire[kExBusAccessAt] = kExBusAnswerAllowed;
    const std::size_t length = end + 1 + kExBusCheckBytes;
    wire[kExBusLengthAt] = static_cast<std::uint8_t>(length);
    wire[kExBusPacketAt] = packet;
    wire[kExBusKindAt] = kExBusTelemetry;
    wire[kExBusDataLengthAt] = static_cast<std::uint8_t>(length - kExBusLeastLength);
    wire[kExBusDataAt] = kExMessage;
    wire[kExKindAndLengthAt] |= static_cast<std::uint8_t>(end - kExKindAndLengthAt);
    put_ex_word(wire, kExMakerAt, kExMaker);
    put_ex_word(wire, kExDeviceAt, device);
    wire[kExReservedAt] = 0;
    const std::span<const std::uint8_t> bytes = wire;
    wire[end] = ExMessageCrc::of(0, bytes.subspan(kExKindAndLengthAt, end - kExKindAndLengthAt));
    put_ex_word(wire, end + 1, ExBusCrc::of(0, bytes.first(end + 1)));
    return length;
}

}  // namespace

ExBusTelemetryEncoder::ExBusTelemetryEncoder(ExBusDevice device)
    : device_(std::move(device)),
      numbers_(device_.sensors.size()),
      units_(device_.sensors.size()) {}

void ExBusTelemetryEncoder::use(const ValueBoard& board) {
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
        const ExBusSensor& sensor = device_.sensors[i];
        if (sensor.form != ExBusNumber::decimal) {
            numbers_[i].find(board, sensor.value, "deg");
            continue;
        }
        numbers_[i].find(board, sensor.value, sensor.unit);
        units_[i] = shown_unit(sensor.unit.empty() ? numbers_[i].own_unit() : sensor.unit);
    }
}

std::optional<AskedTiming> ExBusTelemetryEncoder::hear(std::span<const std::uint8_t> bytes,
                                                       Instant now) {
    asked_.reset();
    if (now - heard_at_ > kExLongestFrameTime) {
        heard_.reset();
    }
    heard_at_ = now;
    heard_bytes_ += bytes.size();
    DecodedFrame request;
    while (heard_.next(bytes, now, request)) {
        if (request.first_byte + request.length == heard_bytes_) {
            asked_ = Request{.packet = heard_.packet, .at = now};
        }
    }
    return asked_ ? std::optional(AskedTiming{.at_once = true}) : std::nullopt;
}

void ExBusTelemetryEncoder::forget_heard() {
    heard_.reset();
    asked_.reset();
}

bool ExBusTelemetryEncoder::Requests::read(std::span<const std::uint8_t> frame,
                                           ChannelFrame& /*channels*/) {
    packet = frame[kExBusPacketAt];
    return frame[0] == kExBusRequest && frame[kExBusAccessAt] == kExBusAnswerAllowed &&
           frame[kExBusKindAt] == kExBusTelemetry;
}

bool ExBusTelemetryEncoder::any_fresh(Instant now) const {
    return std::ranges::any_of(
        numbers_, [now](const SentNumber& number) { return number.fresh(now).has_value(); });
}

std::size_t ExBusTelemetryEncoder::write(const ChannelFrame& /*frame*/,
                                         std::span<std::uint8_t, kLongestSerialFrame> wire,
                                         Instant now) {
    const auto asked = std::exchange(asked_, std::nullopt);
    if (!asked || now - asked->at > kMostDelay || !any_fresh(now)) {
        return 0;
    }
    std::size_t end = 0;
    if (!all_named_ || numbers_left_ == 0) {
        end = write_name(wire);
        next_name_ = (next_name_ + 1) % (device_.sensors.size() + 1);
        all_named_ = all_named_ || next_name_ == 0;
        numbers_left_ = kNumbersPerName;
    } else {
        end = write_numbers(wire, now);
        --numbers_left_;
    }
    return finish_answer(wire, asked->packet, device_.number, end);
}

std::size_t ExBusTelemetryEncoder::write_name(std::span<std::uint8_t> wire) const {
    const bool of_device = next_name_ == 0;
    const std::size_t index = of_device ? 0 : next_name_ - 1;
    const std::string_view label = of_device ? device_.name : device_.sensors[index].label;
    const std::string_view unit = of_device ? std::string_view() : units_[index];
    wire[kExKindAndLengthAt] = kExText;
    wire[kExContentAt] = of_device ? 0 : device_.sensors[index].number;
    wire[kExContentAt + 1] = static_cast<std::uint8_t>(label.size() << 3U | unit.size());
    auto at = std::ranges::copy(label, wire.begin() + kExContentAt + 2).out;
    at = std::ranges::copy(unit, at).out;
    return static_cast<std::size_t>(at - wire.begin());
}

std::size_t ExBusTelemetryEncoder::write_numbers(std::span<std::uint8_t> wire, Instant now) {
    wire[kExKindAndLengthAt] = kExNumbers;
    std::size_t end = kExContentAt;
    for (std::size_t looked_at = 0; looked_at < numbers_.size(); ++looked_at) {
        if (const auto value = numbers_[next_number_].fresh(now)) {
            const bool decimal = device_.sensors[next_number_].form == ExBusNumber::decimal;
            if (end + (decimal ? kExDecimalBytes : kExPositionBytes) > kExContentEnd) {
                break;
            }
            end = write_number(next_number_, *value, wire.subspan(end)) + end;
        }
        next_number_ = (next_number_ + 1) % numbers_.size();
    }
    return end;
}

/// Returns how many bytes it took.
std::size_t ExBusTelemetryEncoder::write_number(std::size_t index, double value,
                                                std::span<std::uint8_t> wire) const {
    const ExBusSensor& sensor = device_.sensors[index];
    const bool decimal = sensor.form == ExBusNumber::decimal;
    const std::size_t bytes = decimal ? kExDecimalBytes : kExPositionBytes;
    std::uint32_t bits = decimal ? decimal_bits(value, sensor.decimals)
                                 : position_bits(value, sensor.form == ExBusNumber::longitude);
    wire[0] = static_cast<std::uint8_t>(sensor.number << 4U |
                                        (decimal ? kExDecimalType : kExPositionType));
    for (std::size_t at = 1; at < bytes; ++at, bits >>= 8U) {
        wire[at] = static_cast<std::uint8_t>(bits);
    }
    return bytes;
}

}  // namespace tribus
