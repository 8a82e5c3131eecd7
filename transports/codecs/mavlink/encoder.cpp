#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cstdint>

#include "core/pulse.h"
#include "transports/codecs/mavlink/mavlink.h"
#include "transports/codecs/microsecond_words.h"

namespace tribus {

using namespace mavlink_wire;

namespace {

constexpr Duration kHeartbeatPeriod = std::chrono::seconds(1);

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

/// Gives these channels back, one bit each. Leaves the words of others as they are.
void put_released(std::uint32_t channels, std::span<std::uint8_t> payload) {
    for (; channels != 0; channels &= channels - 1) {
        const auto channel = static_cast<std::size_t>(std::countr_zero(channels));
        put_field(payload, override_at(channel),
                  channel < kOverrideFirst.count ? kReleasedFirst : kReleasedMore);
    }
}

}  // namespace

MavlinkEncoder::MavlinkEncoder(const Settings& settings)
    : settings_(settings),
      sender_{.version_1 = settings.version_1,
              .system = settings.system,
              .component = settings.component},
      answers_(
          {.message = settings.message, .channels = settings.channels, .target = settings.target}) {
    if (settings.key) {
        sender_.signer.emplace(*settings.key, settings.link_id);
    }
}

std::optional<AskedTiming> MavlinkEncoder::hear(std::span<const std::uint8_t> bytes, Instant now) {
    answers_.hear(bytes, now);
    return std::nullopt;
}

void MavlinkEncoder::forget_heard() {
    answers_.reset();
}

Answers MavlinkEncoder::answers() const {
    return answers_.answers();
}

void MavlinkEncoder::use_clock(const WallClock& clock) {
    if (sender_.signer) {
        sender_.signer->use_clock(clock);
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
    // ArduPilot looks at the failsafe flag only, and would take held values for new ones. The link
    // of a frame that is only marked is good.
    const bool held = frame.frame_lost && frame.cause != LinkCause::good;
    const bool failsafe = frame.failsafe || held;
    put_field<std::uint16_t>(payload, kRadioFlagsAt,
                             static_cast<std::uint16_t>((failsafe ? kRadioFailsafe : 0) |
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
        microsecond_words::put_microseconds(payload, override_at(channel),
                                            microsecond_words::microseconds_of(frame, channel));
    }
    for (std::size_t channel = settings_.channels; channel < kOverrideFirst.count; ++channel) {
        put_field(payload, kOverrideFirst.at + 2 * channel, kIgnored);
    }
    if (fewer_.left > 0) {
        put_released(fewer_.channels, payload);
    }
    payload[kOverrideTargetAt] = settings_.target;
    payload[kOverrideTargetAt + 1] = kAutopilotComponent;
}

// Forward is a long pulse on no usual stick: the axis of pitch runs the other way.
void MavlinkEncoder::fill_manual(const ChannelFrame& frame, Payload& payload) const {
    put_field(payload, kManualRollAt, axis_of(frame, 0));
    put_field(payload, kManualPitchAt, static_cast<std::int16_t>(-axis_of(frame, 1)));
    const std::int16_t throttle = axis_of(frame, 2);
    put_field(payload, kManualThrottleAt,
              settings_.throttle == MavlinkThrottle::centred
                  ? throttle
                  : static_cast<std::int16_t>((throttle + kMostAxisSteps) / 2));
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

std::size_t MavlinkEncoder::write_message(Sender& sender, const MessageKind& kind,
                                          const Payload& payload, std::span<std::uint8_t> wire,
                                          Instant now) {
    std::size_t header = kHeader1Bytes;
    std::size_t length = kind.length_1;
    if (sender.version_1) {
        const auto id = static_cast<std::uint8_t>(kind.id);
        std::ranges::copy(
            std::to_array<std::uint8_t>({kVersion1, static_cast<std::uint8_t>(length), sequence_,
                                         sender.system, sender.component, id}),
            wire.begin());
    } else {
        header = kHeader2Bytes;
        length = kind.length;
        while (length > 1 && payload[length - 1] == 0) {
            --length;
        }
        std::ranges::copy(std::to_array<std::uint8_t>(
                              {kVersion2, static_cast<std::uint8_t>(length),
                               sender.signer ? kSignedFlag : std::uint8_t{0}, 0, sequence_,
                               sender.system, sender.component, static_cast<std::uint8_t>(kind.id),
                               static_cast<std::uint8_t>(kind.id >> 8U),
                               static_cast<std::uint8_t>(kind.id >> 16U)}),
                          wire.begin());
    }
    std::copy_n(payload.begin(), length, wire.begin() + static_cast<std::ptrdiff_t>(header));
    put_field(wire, header + length, crc_of(wire.subspan(1, header + length - 1), kind.crc_extra));
    ++sequence_;
    length += header + kCrcBytes;
    if (sender.signer) {
        sender.signer->sign(wire, length, now);
        length += kSignatureBytes;
    }
    return length;
}

std::size_t MavlinkEncoder::write(const ChannelFrame& frame,
                                  std::span<std::uint8_t, kLongestSerialFrame> wire, Instant now) {
    if (former_ && former_->release.left > 0) {
        return write_release(former_->sender, former_->target, former_->release, wire, now);
    }
    Payload payload{};
    const MessageKind& kind = fill(frame, payload);
    answers_.keep(payload);
    std::size_t length = write_message(sender_, kind, payload, wire, now);
    own_ = {own_channels(), settings_.releases ? kReleases : 0};
    fewer_.left = std::max(fewer_.left - 1, 0);
    if (!heartbeat_at_ || now >= *heartbeat_at_) {
        heartbeat_at_ = now + kHeartbeatPeriod;
        // A ground station without an autopilot, active (docs/protocols/mavlink.md, "Sending").
        const Payload heartbeat{0, 0, 0, 0, 6, 8, 0, 4, 3};
        length += write_message(sender_, kHeartbeat, heartbeat, wire.subspan(length), now);
    }
    return length;
}

std::size_t MavlinkEncoder::write_release(Sender& sender, std::uint8_t target, Release& release,
                                          std::span<std::uint8_t> wire, Instant now) {
    --release.left;
    Payload payload{};
    for (std::size_t channel = 0; channel < kOverrideFirst.count; ++channel) {
        put_field(payload, override_at(channel), kIgnored);
    }
    put_released(release.channels, payload);
    payload[kOverrideTargetAt] = target;
    payload[kOverrideTargetAt + 1] = kAutopilotComponent;
    return write_message(sender, kRcChannelsOverride, payload, wire, now);
}

std::size_t MavlinkEncoder::write_silence(std::span<std::uint8_t, kLongestSerialFrame> wire,
                                          Instant now) {
    if (former_ && former_->release.left > 0) {
        return write_release(former_->sender, former_->target, former_->release, wire, now);
    }
    if (own_.left == 0 && fewer_.left == 0) {
        return 0;
    }
    Release both{(own_.left > 0 ? own_.channels : 0) | (fewer_.left > 0 ? fewer_.channels : 0), 1};
    fewer_.left = std::max(fewer_.left - 1, 0);
    if (own_.left > 0 && --own_.left == 0) {
        own_.channels = 0;
    }
    return write_release(sender_, settings_.target, both, wire, now);
}

/// The channels that it takes over.
std::uint32_t MavlinkEncoder::own_channels() const {
    return settings_.message == MavlinkChannels::rc_channels_override
               ? first_channels(settings_.channels)
               : 0;
}

void MavlinkEncoder::continue_from(const Encoder& before) {
    if (const auto* same = dynamic_cast<const MavlinkEncoder*>(&before)) {
        sequence_ = same->sequence_;
        heartbeat_at_ = same->heartbeat_at_;
        if (sender_.signer && same->sender_.signer) {
            sender_.signer->continue_from(*same->sender_.signer);
        }
        if (settings_.system == same->settings_.system) {
            answers_.continue_from(same->answers_);
        }
        give_back_for(*same);
    }
}

/// Overrides of a channel that nobody sends any more would last as long as the autopilot says, for
/// ever with RC_OVERRIDE_TIME -1.
void MavlinkEncoder::give_back_for(const MavlinkEncoder& before) {
    const Settings& old = before.settings_;
    const bool same_link = settings_.target == old.target && settings_.system == old.system &&
                           settings_.component == old.component && settings_.key == old.key;
    const std::uint32_t own = same_link ? own_channels() : 0;
    own_.channels = own & before.own_.channels;
    if (own_.channels != 0 && settings_.releases) {
        own_.left = before.settings_.releases ? before.own_.left : kReleases;
    }
    former_ = before.former_;
    if (former_ && former_->release.left > 0) {
        // It goes on first. Meanwhile no channels were sent.
        return;
    }
    const std::uint32_t taken =
        before.own_.channels | (before.fewer_.left > 0 ? before.fewer_.channels : 0);
    const Release release{taken & ~own, kReleases};
    if (release.channels == 0 || !(settings_.releases || before.settings_.releases)) {
        return;
    }
    const std::uint32_t reached =
        settings_.version_1 ? first_channels(kOverrideFirst.count) : kAllChannels;
    if (own != 0 && (release.channels & ~reached) == 0) {
        fewer_ = release;
    } else {
        former_ = Former{before.sender_, before.settings_.target, release};
    }
}

}  // namespace tribus
