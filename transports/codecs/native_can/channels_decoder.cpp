#include <algorithm>
#include <chrono>
#include <cstdlib>

#include "transports/codecs/native_can/channels.h"

namespace tribus {

using namespace can_channels;

CanChannelsDecoder::CanChannelsDecoder(const CanChannelsFormat& format)
    : format_(format),
      ids_(can_channels_ids(format)),
      watch_({.values = format.counter_values(), .most_step = kMostAdvance, .silence = kSilence}) {}

std::optional<ChannelFrame> CanChannelsDecoder::next(const CanFrame& frame, Instant received) {
    const auto ids = wanted();
    const auto match = std::ranges::find_if(
        ids, [&](const CanIdMatch& wanted_id) { return wanted_id.matches(frame); });
    if (match == ids.end()) {
        return std::nullopt;
    }
    const auto part = static_cast<std::size_t>(match - ids.begin());
    if (!valid(frame, part)) {
        return std::nullopt;
    }
    expire(received);
    const bool whole = part == 0 ? take_first(frame, received) : take_further(frame, part);
    if (!whole) {
        return std::nullopt;
    }
    collection_ = Collection::none;
    return continues(received) ? std::optional(publish(received)) : std::nullopt;
}

bool CanChannelsDecoder::valid(const CanFrame& frame, std::size_t part) {
    if (frame.remote || frame.fd != format_.fd || frame.length != format_.frame_length()) {
        ++rejected_[kLength].count;
        return false;
    }
    const std::size_t index = format_.first_index() + part;
    const std::uint16_t sent_crc = get(frame.bytes(), format_.fd ? kFdCrc : kCrc8);
    // A counter that the profile never sends belongs to another profile.
    if (sent_crc != can_channels_crc(format_, index, frame.bytes()) ||
        counter_of(frame) >= format_.counter_values()) {
        ++rejected_[kChecksum].count;
        return false;
    }
    return true;
}

unsigned CanChannelsDecoder::counter_of(const CanFrame& frame) const {
    return get(frame.bytes(), format_.fd ? kFdCounter : kCounter);
}

void CanChannelsDecoder::add(const CanFrame& frame) {
    std::ranges::copy(frame.bytes(), parts_[taken_].begin());
    ++taken_;
}

bool CanChannelsDecoder::same_as_taken(const CanFrame& frame, std::size_t part) const {
    return std::ranges::equal(frame.bytes(), std::span(parts_[part]).first(format_.frame_length()));
}

void CanChannelsDecoder::expire(Instant received) {
    // A receiver's time stamps may also run backwards a little.
    if (collection_ == Collection::none || std::chrono::abs(received - begun_) <= kWindow) {
        return;
    }
    if (collection_ == Collection::running) {
        ++rejected_[kIncomplete].count;
    }
    collection_ = Collection::none;
}

/// Ignores the rest of the snapshot with this counter, for as long as its frames may still arrive.
void CanChannelsDecoder::discard(RejectCause cause) {
    ++rejected_[cause].count;
    collection_ = Collection::discarded;
}

bool CanChannelsDecoder::take_first(const CanFrame& frame, Instant received) {
    const unsigned counter = counter_of(frame);
    if (collection_ != Collection::none && counter == counter_) {
        if (collection_ == Collection::discarded) {
            ++rejected_[kStray].count;
        } else if (!same_as_taken(frame, 0)) {
            discard(kConflict);
            watch_.require_long_proof();
        }
        // Otherwise the bus repeated the frame, after an error in its last bit that only the sender
        // saw.
        return false;
    }
    interrupted_.reset();
    if (collection_ == Collection::running) {
        ++rejected_[kIncomplete].count;
        interrupted_ = counter_;
    }
    collection_ = Collection::running;
    counter_ = counter;
    begun_ = received;
    taken_ = 0;
    add(frame);
    return taken_ == format_.frame_count();
}

bool CanChannelsDecoder::take_further(const CanFrame& frame, std::size_t part) {
    if (collection_ != Collection::running || counter_of(frame) != counter_) {
        ++rejected_[kStray].count;
        // Another snapshot continues inside this one, or after the one that replaced it: a second
        // sender.
        if (collection_ == Collection::running || counter_of(frame) == interrupted_) {
            watch_.restart_proof();
        }
        return false;
    }
    if (part > taken_) {
        discard(kIncomplete);
        return false;
    }
    if (part < taken_) {
        if (!same_as_taken(frame, part)) {
            discard(kConflict);
            watch_.require_long_proof();
        }
        return false;
    }
    add(frame);
    return taken_ == format_.frame_count();
}

bool CanChannelsDecoder::continues(Instant received) {
    // Unused bytes and frames are zero in both.
    const bool same = parts_ == reference_;
    reference_ = parts_;
    switch (watch_.take(counter_, same, received)) {
        case CounterWatch::Verdict::good:
            return true;
        case CounterWatch::Verdict::unconfirmed:
            ++rejected_[kUnconfirmed].count;
            break;
        case CounterWatch::Verdict::repeated:
            ++rejected_[kRepeated].count;
            break;
        case CounterWatch::Verdict::conflict:
            ++rejected_[kConflict].count;
            break;
        case CounterWatch::Verdict::jump:
            ++rejected_[kCounterJump].count;
            break;
    }
    return false;
}

void CanChannelsDecoder::read_classic(ChannelFrame& channels, CanChannelsOrigin& origin) const {
    CanChannelsStatus any{};
    const auto set = [&](const auto& raw, std::size_t first) {
        for (std::size_t place = 0; place < raw.size(); ++place) {
            channels.set(first + place, from_wire(kClassicPulse, raw[place]));
        }
    };
    for (std::size_t part = 0; part < kQuads; ++part) {
        const CanChannelsQuad quad = parse_can_quad(parts_[part]);
        set(quad.raw, part * kChannelsPerQuad);
        any.merge(quad.status);
    }
    if (format_.frame_count() > kTailIndex) {
        const CanChannelsTail tail = parse_can_tail(parts_[kTailIndex]);
        set(tail.raw, kQuadChannels);
        any.merge(tail.status);
        origin = tail.origin;
    } else {
        channels.set(16, any.digital_17 ? kSwitchOnPulse : kSwitchOffPulse);
        channels.set(17, any.digital_18 ? kSwitchOnPulse : kSwitchOffPulse);
    }
    channels.failsafe = any.failsafe;
    channels.frame_lost = any.frame_lost;
}

void CanChannelsDecoder::read_fd(ChannelFrame& channels, CanChannelsOrigin& origin) const {
    const CanChannelsFd frame = parse_can_fd(parts_[0]);
    for (std::size_t channel = 0; channel < frame.raw.size(); ++channel) {
        channels.set(channel, from_wire(kFdPulse, frame.raw[channel]));
    }
    channels.failsafe = frame.status.failsafe;
    channels.frame_lost = frame.status.frame_lost;
    origin = frame.origin;
}

ChannelFrame CanChannelsDecoder::publish(Instant received) {
    ChannelFrame channels;
    CanChannelsOrigin origin;
    const AgeScale& age = format_.fd ? kFdAgeScale : kTailAgeScale;
    origin.age = age.not_available;
    if (format_.fd) {
        read_fd(channels, origin);
    } else {
        read_classic(channels, origin);
    }
    channels.received = received;
    if (origin.age < age.not_available) {
        channels.received -= origin.age * std::chrono::microseconds(age.step_microseconds);
    }
    // The greatest age also stands for every greater one. If the values had been refreshed since
    // the snapshot before, the age would be lower, so they are at least as old as those.
    if (origin.age == age.not_available - 1) {
        channels.received = std::min(channels.received, published_received_);
    }
    published_received_ = channels.received;
    channels.link_quality =
        origin.link_quality <= kMostLinkQuality ? origin.link_quality : kNoLinkQuality;
    channels.origin = source_from_wire(origin.source);
    set_details(origin);
    return channels;
}

void CanChannelsDecoder::set_details(const CanChannelsOrigin& origin) {
    detail_count_ = 0;
    add_detail("counter", static_cast<std::uint16_t>(counter_));
    if (format_.frame_count() == kQuads) {
        return;
    }
    add_detail("source", origin.source);
    if (origin.link_quality <= kMostLinkQuality) {
        add_detail("link_quality", origin.link_quality);
    }
    const AgeScale& age = format_.fd ? kFdAgeScale : kTailAgeScale;
    if (origin.age < age.not_available) {
        add_detail("age_10us",
                   static_cast<std::uint16_t>(origin.age * (age.step_microseconds / 10)));
    }
}

void CanChannelsDecoder::add_detail(std::string_view name, std::uint16_t value) {
    detail_values_[detail_count_] = value;
    details_[detail_count_] = {name, std::span(detail_values_).subspan(detail_count_, 1), false};
    ++detail_count_;
}

}  // namespace tribus
