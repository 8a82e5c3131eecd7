#include "transports/codecs/mavlink/answers.h"

#include <algorithm>
#include <cstdlib>

namespace tribus {

using namespace mavlink_wire;

namespace {

/// MAV_AUTOPILOT_INVALID: a ground station, a radio, a camera.
constexpr std::uint8_t kNoAutopilot = 8;
/// Autopilots round.
constexpr int kNearMicroseconds = 2;

int microseconds_sent(std::span<const std::uint8_t> payload, bool radio, std::size_t channel) {
    if (radio) {
        // A step is 5/32 us.
        return 1500 + field_at<std::int16_t>(payload, kRadioChannelsAt + 2 * channel) * 5 / 32;
    }
    const bool first = channel < kOverrideFirst.count;
    return field_at<std::uint16_t>(payload,
                                   first ? kOverrideFirst.at + 2 * channel
                                         : kOverrideMore.at + 2 * (channel - kOverrideFirst.count));
}

}  // namespace

void MavlinkAnswers::keep(std::span<const std::uint8_t> payload) {
    std::copy_n(payload.begin(), std::tuple_size_v<Kept>, kept_[next_].begin());
    next_ = (next_ + 1) % kKept;
    count_ += count_ < kKept ? 1U : 0U;
}

void MavlinkAnswers::hear(std::span<const std::uint8_t> bytes, Instant now) {
    DecodedFrame frame;
    while (next(bytes, now, frame)) {
    }
}

void MavlinkAnswers::continue_from(const MavlinkAnswers& before) {
    if (before.sent_ == sent_) {
        kept_ = before.kept_;
        next_ = before.next_;
        count_ = before.count_;
        answers_ = before.answers_;
    }
}

/// Words behind those of the autopilot's receiver may be unused, 0 or 65535: ArduPilot counts the
/// channels of its receiver only, PX4 those that it has. They tell nothing, so half of the channels
/// must be shown at least.
bool MavlinkAnswers::shows(const Kept& kept, const MavlinkMessage& message) const {
    std::size_t shown = 0;
    for (std::size_t channel = 0; channel < sent_.channels; ++channel) {
        const int word = field_at<std::uint16_t>(message.payload, kRcChannelsAt + 2 * channel);
        if (channel >= message.payload[kRcCountAt] && (word == 0 || word == kIgnored)) {
            continue;
        }
        const bool radio = sent_.message == MavlinkChannels::radio_rc_channels;
        if (std::abs(word - microseconds_sent(kept, radio, channel)) > kNearMicroseconds) {
            return false;
        }
        ++shown;
    }
    return 2 * shown >= sent_.channels;
}

void MavlinkAnswers::take_heartbeat(const MavlinkMessage& message) {
    const std::uint8_t autopilot = message.payload[kHeartbeatAutopilotAt];
    if (message.system == sent_.target) {
        ++answers_.heard;
        answers_.kind =
            static_cast<std::uint16_t>(autopilot << 8U | message.payload[kHeartbeatTypeAt]);
    } else if (autopilot != kNoAutopilot) {
        ++answers_.heard_others;
        answers_.other = message.system;
    }
}

/// Nothing of it is a frame with channels.
bool MavlinkAnswers::take(const MavlinkMessage& message, ChannelFrame& /*channels*/) {
    if (message.component != kAutopilotComponent) {
        return false;
    }
    if (message.id == kHeartbeat.id) {
        take_heartbeat(message);
    } else if (message.id == kRcChannels.id && message.system == sent_.target &&
               sent_.message != MavlinkChannels::manual_control) {
        const auto kept = std::span(kept_).first(count_);
        answers_.effect = answers_.effect || std::ranges::any_of(kept, [&](const Kept& one) {
                              return shows(one, message);
                          });
    }
    return false;
}

}  // namespace tribus
