#include <algorithm>
#include <cstdint>

#include "core/pulse.h"
#include "transports/codecs/mavlink/mavlink.h"
#include "transports/codecs/microsecond_words.h"

namespace tribus {

using namespace mavlink_wire;

namespace {

/// MAV_SYS_STATUS_SENSOR_RC_RECEIVER.
constexpr std::uint32_t kReceiverBit = 0x10000;
constexpr std::size_t kEnabledAt = 4;
constexpr std::size_t kHealthAt = 8;

constexpr int kCentreAxis = kCentrePulse.eighths();
constexpr int kLeastEighths = 8 * 1000;
constexpr int kMostAxis = 1000;

/// Which message it is; nothing for others.
std::optional<MavlinkChannels> channels_message(std::uint32_t id) {
    switch (id) {
        case kRadioRcChannels.id:
            return MavlinkChannels::radio_rc_channels;
        case kRcChannelsOverride.id:
            return MavlinkChannels::rc_channels_override;
        case kRcChannels.id:
            return MavlinkChannels::rc_channels;
        case kManualControl.id:
            return MavlinkChannels::manual_control;
        default:
            return std::nullopt;
    }
}

using MavlinkPayload = std::span<const std::uint8_t>;

void read_pulse_words(MavlinkPayload payload, ChannelPlace place, std::size_t first,
                      ChannelFrame& channels) {
    for (std::size_t i = 0; i < place.count; ++i) {
        const unsigned word = microsecond_words::microseconds_at(payload, place.at + 2 * i);
        channels.set(first + i, microsecond_words::pulse_of(word));
    }
}

void read_radio(MavlinkPayload payload, ChannelFrame& channels) {
    const auto flags = field_at<std::uint16_t>(payload, kRadioFlagsAt);
    channels.failsafe = (flags & kRadioFailsafe) != 0;
    channels.frame_lost = (flags & kRadioOutdated) != 0;
    const std::size_t count = std::min<std::size_t>(payload[kRadioCountAt], kChannelCount);
    for (std::size_t i = 0; i < count; ++i) {
        // A step is 5/32 us, 5/4 of an eighth. Rounds to the next one.
        const int steps = field_at<std::int16_t>(payload, kRadioChannelsAt + 2 * i);
        channels.set(i, Pulse::from_eighths(kCentreAxis + ((5 * steps + 2) >> 2)));
    }
}

/// The pulse of an axis from -1000 to 1000; nothing beyond, where MAVLink says "not valid".
std::optional<Pulse> pulse_of_axis(MavlinkPayload payload, std::size_t at, int sign) {
    const int axis = field_at<std::int16_t>(payload, at);
    if (axis < -kMostAxis || axis > kMostAxis) {
        return std::nullopt;
    }
    return Pulse::from_eighths(kCentreAxis + sign * axis * 4);
}

/// A vehicle that does not reverse stands still below 0.
std::optional<Pulse> pulse_of_throttle(MavlinkPayload payload, MavlinkThrottle throttle) {
    const auto centred = pulse_of_axis(payload, kManualThrottleAt, 1);
    if (!centred || throttle == MavlinkThrottle::centred) {
        return centred;
    }
    const int axis = field_at<std::int16_t>(payload, kManualThrottleAt);
    return Pulse::from_eighths(kLeastEighths + 8 * std::max(axis, 0));
}

void read_manual(MavlinkPayload payload, const MavlinkDecoder::Settings& settings,
                 ChannelFrame& channels) {
    channels.set(0, pulse_of_axis(payload, kManualRollAt, 1));
    channels.set(1, pulse_of_axis(payload, kManualPitchAt, -1));
    channels.set(2, pulse_of_throttle(payload, settings.throttle));
    channels.set(3, pulse_of_axis(payload, kManualYawAt, 1));
    const auto pressed = field_at<std::uint16_t>(payload, kManualButtonsAt);
    for (std::size_t button = 0; button < settings.buttons; ++button) {
        const bool on = (pressed >> button & 1U) != 0;
        channels.set(4 + button, on ? kSwitchOnPulse : kSwitchOffPulse);
    }
}

}  // namespace

void MavlinkDecoder::reset() {
    MavlinkMessages::reset();
    sender_.forget();
    without_signal_.reset();
}

void MavlinkDecoder::take_status(const MavlinkMessage& message) {
    const MavlinkPayload payload(message.payload);
    const auto enabled = field_at<std::uint32_t>(payload, kEnabledAt);
    const auto health = field_at<std::uint32_t>(payload, kHealthAt);
    without_signal_[message.system] = (enabled & ~health & kReceiverBit) != 0;
}

bool MavlinkDecoder::is_for_target(const MavlinkMessage& message) const {
    std::size_t at = 0;
    switch (message.id) {
        case kRadioRcChannels.id:
            at = kRadioTargetAt;
            break;
        case kRcChannelsOverride.id:
            at = kOverrideTargetAt;
            break;
        case kManualControl.id:
            at = kManualTargetAt;
            break;
        default:
            return true;
    }
    return message.payload[at] == 0 || message.payload[at] == settings_.target;
}

bool MavlinkDecoder::is_wanted(const MavlinkMessage& message, Instant received) {
    const auto kind = channels_message(message.id);
    if (!kind || (settings_.message && kind != settings_.message) || !is_for_target(message)) {
        return false;
    }
    // What another component says of a receiver is not what the autopilot acts on.
    const bool of_another_receiver =
        kind == MavlinkChannels::rc_channels && message.component != kAutopilotComponent;
    if (of_another_receiver || !sender_.sent(message, message.id, received)) {
        refuse_sender();
        return false;
    }
    return true;
}

bool MavlinkDecoder::take(const MavlinkMessage& message, ChannelFrame& channels) {
    if (message.id == kSysStatus.id) {
        if (message.component == kAutopilotComponent) {
            take_status(message);
        }
        return false;
    }
    if (!is_wanted(message, channels.received)) {
        return false;
    }
    system_ = message.system;
    const MavlinkPayload payload(message.payload);
    switch (message.id) {
        case kRadioRcChannels.id:
            read_radio(payload, channels);
            break;
        case kRcChannelsOverride.id:
            read_pulse_words(payload, kOverrideFirst, 0, channels);
            read_pulse_words(payload, kOverrideMore, kOverrideFirst.count, channels);
            break;
        case kManualControl.id:
            read_manual(payload, settings_, channels);
            break;
        default:
            read_pulse_words(
                payload, {kRcChannelsAt, std::min<std::size_t>(payload[kRcCountAt], kChannelCount)},
                0, channels);
            channels.failsafe = without_signal_[message.system];
    }
    return true;
}

}  // namespace tribus
