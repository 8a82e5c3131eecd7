#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>

#include "core/pulse.h"
#include "transports/codecs/mavlink/mavlink.h"
#include "transports/codecs/microsecond_words.h"

namespace tribus {

using namespace mavlink_wire;

namespace {

constexpr Duration kHeartbeatPeriod = std::chrono::seconds(1);
/// So often the channels are given back, because a datagram can get lost.
constexpr int kReleases = 10;

constexpr std::uint8_t kAutopilotComponent = 1;
constexpr int kMostRadioStep = 4096;
constexpr int kMostAxisSteps = 1000;

int offset_of(const ChannelFrame& frame, std::size_t channel) {
    return frame.channel(channel).value_or(kCentrePulse).eighths() - kCentrePulse.eighths();
}

/// A quotient to the next whole number, halves upwards.
constexpr int nearest_quotient(int value, int divisor) {
    const int doubled = 2 * value + divisor;
    const int quotient = doubled / (2 * divisor);
    return doubled < 0 && quotient * 2 * divisor != doubled ? quotient - 1 : quotient;
}

/// From -1000 at 1000 us to 1000 at 2000 us.
std::int16_t axis_of(const ChannelFrame& frame, std::size_t channel) {
    return static_cast<std::int16_t>(std::clamp(nearest_quotient(offset_of(frame, channel), 4),
                                                -kMostAxisSteps, kMostAxisSteps));
}

bool is_pressed(const ChannelFrame& frame, std::size_t channel) {
    return offset_of(frame, channel) > 0;
}

}  // namespace

MavlinkEncoder::MavlinkEncoder(const Settings& settings) : settings_(settings) {
    if (settings.key) {
        signer_.emplace(*settings.key, settings.link_id);
    }
    if (settings.message != MavlinkChannels::manual_control) {
        answers_.emplace(
            MavlinkSent{.radio = settings.message == MavlinkChannels::radio_rc_channels,
                        .channels = settings.channels,
                        .target = settings.target});
    }
}

std::optional<AskedTiming> MavlinkEncoder::hear(std::span<const std::uint8_t> bytes, Instant now) {
    if (answers_) {
        answers_->hear(bytes, now);
    }
    return std::nullopt;
}

void MavlinkEncoder::forget_heard() {
    if (answers_) {
        answers_->reset();
    }
}

Answers MavlinkEncoder::answers() const {
    return answers_ ? answers_->answers() : Answers{};
}

void MavlinkEncoder::use_clock(const WallClock& clock) {
    if (signer_) {
        signer_->use_clock(clock);
    }
}

std::uint32_t MavlinkEncoder::needed_channels(const ChannelFrame& /*frame*/) const {
    return first_channels(settings_.message == MavlinkChannels::manual_control
                              ? 4 + settings_.buttons
                              : settings_.channels);
}

void MavlinkEncoder::fill_radio(const ChannelFrame& frame, Payload& payload) const {
    const auto at = std::chrono::floor<std::chrono::milliseconds>(frame.received);
    put_field(payload, 0, static_cast<std::uint32_t>(at.time_since_epoch().count()));
    put_field<std::uint16_t>(payload, kRadioFlagsAt,
                             static_cast<std::uint16_t>((frame.failsafe ? kRadioFailsafe : 0) |
                                                        (frame.frame_lost ? kRadioOutdated : 0)));
    payload[kRadioTargetAt] = settings_.target;
    payload[kRadioCountAt] = static_cast<std::uint8_t>(settings_.channels);
    for (std::size_t channel = 0; channel < settings_.channels; ++channel) {
        const int steps = nearest_quotient(4 * offset_of(frame, channel), 5);
        put_field(payload, kRadioChannelsAt + 2 * channel,
                  static_cast<std::int16_t>(std::clamp(steps, -kMostRadioStep, kMostRadioStep)));
    }
}

void MavlinkEncoder::fill_override(const ChannelFrame& frame, Payload& payload) const {
    for (std::size_t channel = 0; channel < settings_.channels; ++channel) {
        const std::size_t at = channel < kOverrideFirst.count
                                   ? kOverrideFirst.at + 2 * channel
                                   : kOverrideMore.at + 2 * (channel - kOverrideFirst.count);
        microsecond_words::put_microseconds(payload, at,
                                            microsecond_words::microseconds_of(frame, channel));
    }
    for (std::size_t channel = settings_.channels; channel < kOverrideFirst.count; ++channel) {
        put_field(payload, kOverrideFirst.at + 2 * channel, kIgnored);
    }
    payload[kOverrideTargetAt] = settings_.target;
    payload[kOverrideTargetAt + 1] = kAutopilotComponent;
}

// Forward is a long pulse on no usual stick: the axis of pitch runs the other way.
void MavlinkEncoder::fill_manual(const ChannelFrame& frame, Payload& payload) const {
    put_field(payload, kManualRollAt, axis_of(frame, 0));
    put_field(payload, kManualPitchAt, static_cast<std::int16_t>(-axis_of(frame, 1)));
    put_field(payload, kManualThrottleAt,
              static_cast<std::int16_t>((axis_of(frame, 2) + kMostAxisSteps) / 2));
    put_field(payload, kManualYawAt, axis_of(frame, 3));
    unsigned pressed = 0;
    for (std::size_t button = 0; button < settings_.buttons; ++button) {
        pressed |= (is_pressed(frame, 4 + button) ? 1U : 0U) << button;
    }
    put_field(payload, kManualButtonsAt, static_cast<std::uint16_t>(pressed));
    payload[kManualTargetAt] = settings_.target;
}

const MessageKind& MavlinkEncoder::fill(const ChannelFrame& frame, Payload& payload) const {
    switch (settings_.message) {
        case MavlinkChannels::rc_channels_override:
            fill_override(frame, payload);
            return kRcChannelsOverride;
        case MavlinkChannels::manual_control:
            fill_manual(frame, payload);
            return kManualControl;
        default:
            fill_radio(frame, payload);
            return kRadioRcChannels;
    }
}

std::size_t MavlinkEncoder::write_message(const MessageKind& kind, const Payload& payload,
                                          std::span<std::uint8_t> wire, Instant now) {
    std::size_t header = kHeader1Bytes;
    std::size_t length = kind.length_1;
    if (settings_.version_1) {
        const auto id = static_cast<std::uint8_t>(kind.id);
        std::ranges::copy(
            std::to_array<std::uint8_t>({kVersion1, static_cast<std::uint8_t>(length), sequence_,
                                         settings_.system, settings_.component, id}),
            wire.begin());
    } else {
        header = kHeader2Bytes;
        length = kind.length;
        while (length > 1 && payload[length - 1] == 0) {
            --length;
        }
        std::ranges::copy(
            std::to_array<std::uint8_t>({kVersion2, static_cast<std::uint8_t>(length),
                                         signer_ ? kSignedFlag : std::uint8_t{0}, 0, sequence_,
                                         settings_.system, settings_.component,
                                         static_cast<std::uint8_t>(kind.id),
                                         static_cast<std::uint8_t>(kind.id >> 8U),
                                         static_cast<std::uint8_t>(kind.id >> 16U)}),
            wire.begin());
    }
    std::copy_n(payload.begin(), length, wire.begin() + static_cast<std::ptrdiff_t>(header));
    put_field(wire, header + length, crc_of(wire.subspan(1, header + length - 1), kind.crc_extra));
    ++sequence_;
    length += header + kCrcBytes;
    if (signer_) {
        signer_->sign(wire, length, now);
        length += kSignatureBytes;
    }
    return length;
}

std::size_t MavlinkEncoder::write(const ChannelFrame& frame,
                                  std::span<std::uint8_t, kLongestSerialFrame> wire, Instant now) {
    Payload payload{};
    const MessageKind& kind = fill(frame, payload);
    if (answers_) {
        answers_->keep(payload);
    }
    std::size_t length = write_message(kind, payload, wire, now);
    releases_left_ = settings_.releases ? kReleases : 0;
    if (!heartbeat_at_ || now >= *heartbeat_at_) {
        heartbeat_at_ = now + kHeartbeatPeriod;
        // A ground station without an autopilot, active (docs/protocols/mavlink.md, "Sending").
        const Payload heartbeat{0, 0, 0, 0, 6, 8, 0, 4, 3};
        length += write_message(kHeartbeat, heartbeat, wire.subspan(length), now);
    }
    return length;
}

std::size_t MavlinkEncoder::write_silence(std::span<std::uint8_t, kLongestSerialFrame> wire,
                                          Instant now) {
    if (releases_left_ == 0) {
        return 0;
    }
    --releases_left_;
    Payload payload{};
    payload[kOverrideTargetAt] = settings_.target;
    payload[kOverrideTargetAt + 1] = kAutopilotComponent;
    for (std::size_t i = 0; i < kOverrideMore.count; ++i) {
        put_field(payload, kOverrideMore.at + 2 * i, kReleasedMore);
    }
    return write_message(kRcChannelsOverride, payload, wire, now);
}

void MavlinkEncoder::continue_from(const Encoder& before) {
    if (const auto* same = dynamic_cast<const MavlinkEncoder*>(&before)) {
        sequence_ = same->sequence_;
        heartbeat_at_ = same->heartbeat_at_;
        releases_left_ = same->releases_left_;
        if (signer_ && same->signer_) {
            signer_->continue_from(*same->signer_);
        }
        if (answers_ && same->answers_ && settings_.system == same->settings_.system) {
            answers_->continue_from(*same->answers_);
        }
    }
}

}  // namespace tribus
