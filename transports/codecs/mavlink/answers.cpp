#include "transports/codecs/mavlink/answers.h"

#include <algorithm>
#include <cstdlib>

namespace tribus {

using namespace mavlink_wire;

namespace {

constexpr std::uint8_t kMainComponent = 1;
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

bool MavlinkAnswers::shows(const Kept& kept, const MavlinkMessage& message) const {
    for (std::size_t channel = 0; channel < sent_.channels; ++channel) {
        const int shown = field_at<std::uint16_t>(message.payload, kRcChannelsAt + 2 * channel);
        if (std::abs(shown - microseconds_sent(kept, sent_.radio, channel)) > kNearMicroseconds) {
            return false;
        }
    }
    return true;
}

/// Nothing of it is a frame with channels.
bool MavlinkAnswers::take(const MavlinkMessage& message, ChannelFrame& /*channels*/) {
    if (message.system != sent_.target || message.component != kMainComponent) {
        return false;
    }
    if (message.id == kHeartbeat.id) {
        ++answers_.heard;
    } else if (message.id == kRcChannels.id && message.payload[kRcCountAt] >= sent_.channels) {
        const auto kept = std::span(kept_).first(count_);
        answers_.effect = answers_.effect || std::ranges::any_of(kept, [&](const Kept& one) {
                              return shows(one, message);
                          });
    }
    return false;
}

}  // namespace tribus
