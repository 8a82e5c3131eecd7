#include "transports/codecs/crsf/telemetry.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "transports/codecs/crc8_d5.h"
#include "transports/codecs/crsf/wire.h"

namespace tribus {

using namespace crsf_wire;

namespace {

/// The number as it stands in the frame, before it is rounded.
double scaled_number(const CrsfTelemetryField& field, double value) {
    constexpr double kTurn = 360;
    const double turned = field.is_turn ? value - kTurn * std::floor(value / kTurn) : value;
    return turned * field.scale + field.offset;
}

/// Whether the number is negative and stands in a field without a sign.
bool lacks_sign_in(const CrsfTelemetryField& field, double scaled) {
    return !field.is_signed && scaled < -0.5;
}

/// Puts the number at the end of the payload. Returns the new length.
std::size_t put_number(const CrsfTelemetryField& field, double scaled, std::span<std::uint8_t> wire,
                       std::size_t at) {
    const double range = std::ldexp(1.0, static_cast<int>(8 * field.bytes));
    const double least = field.is_signed ? -range / 2 : 0;
    const double most = field.is_signed ? range / 2 - 1 : range - 1;
    const auto bits = static_cast<std::uint64_t>(std::llround(std::clamp(scaled, least, most)));
    for (std::size_t byte = 0; byte < field.bytes; ++byte) {
        wire[at + byte] = static_cast<std::uint8_t>(bits >> (8 * (field.bytes - 1 - byte)));
    }
    return at + field.bytes;
}

/// The text with that number, or nothing.
const std::string* text_of(const CrsfTelemetryFrame& frame, double number) {
    const double whole = std::round(number);
    const bool known = whole >= 0 && whole < static_cast<double>(frame.texts.size());
    return known ? &frame.texts[static_cast<std::size_t>(whole)] : nullptr;
}

}  // namespace

CrsfTelemetryEncoder::CrsfTelemetryEncoder(std::vector<CrsfTelemetryFrame> frames)
    : frames_(std::move(frames)) {
    for (const CrsfTelemetryFrame& frame : frames_) {
        first_number_.push_back(numbers_.size());
        numbers_.resize(numbers_.size() + frame.fields.size());
    }
}

void CrsfTelemetryEncoder::use(const ValueBoard& board) {
    std::size_t place = 0;
    for (const CrsfTelemetryFrame& frame : frames_) {
        for (const CrsfTelemetryField& field : frame.fields) {
            numbers_[place++].find(board, field.value, field.unit);
        }
    }
}

std::size_t CrsfTelemetryEncoder::write(const ChannelFrame& /*frame*/,
                                        std::span<std::uint8_t, kLongestSerialFrame> wire,
                                        Instant now) {
    for (std::size_t tries = 0; tries < frames_.size(); ++tries) {
        const std::size_t index = next_;
        next_ = (next_ + 1) % frames_.size();
        if (const std::size_t length = write_frame(index, wire, now); length > 0) {
            return length;
        }
    }
    return 0;
}

std::size_t CrsfTelemetryEncoder::write_frame(std::size_t index, std::span<std::uint8_t> wire,
                                              Instant now) const {
    const CrsfTelemetryFrame& frame = frames_[index];
    std::size_t at = kPayloadAt;
    for (const std::uint8_t byte : frame.prefix) {
        wire[at++] = byte;
    }
    for (std::size_t i = 0; i < frame.fields.size(); ++i) {
        const CrsfTelemetryField& field = frame.fields[i];
        const auto value = field.value.empty() ? std::optional(0.0)
                                               : numbers_[first_number_[index] + i].fresh(now);
        if (!value) {
            return 0;
        }
        if (frame.texts.empty()) {
            const double scaled = scaled_number(field, *value);
            if (lacks_sign_in(field, scaled)) {
                return 0;
            }
            at = put_number(field, scaled, wire, at);
            continue;
        }
        const std::string* text = text_of(frame, *value);
        if (text == nullptr) {
            return 0;
        }
        std::ranges::copy(*text, wire.begin() + static_cast<std::ptrdiff_t>(at));
        at += text->size();
        wire[at++] = 0;
    }
    wire[0] = kFlightController;
    wire[kLengthAt] = static_cast<std::uint8_t>(at + 1 - kUncounted);
    wire[kTypeAt] = frame.type;
    wire[at] = Crc8D5::of(0, std::span<const std::uint8_t>(wire).subspan(kTypeAt, at - kTypeAt));
    return at + 1;
}

}  // namespace tribus
