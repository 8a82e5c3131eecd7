#include "transports/codecs/native_can/channels.h"

#include <algorithm>

#include "transports/codecs/e2e.h"

namespace tribus {

using namespace can_channels;

namespace {

/// Status fields of classic frames and of FD frames.
struct StatusFields {
    Field counter;
    std::array<Field, kFlagCount> flags;
};
constexpr StatusFields kClassicStatus{kCounter, kFlags};
constexpr StatusFields kFdStatus{kFdCounter, kFdFlags};

CanChannelsStatus parse_status(const StatusFields& fields, std::span<const std::uint8_t> payload) {
    const auto flag = [&](std::size_t index) { return get(payload, fields.flags[index]) != 0; };
    return {.counter = static_cast<std::uint8_t>(get(payload, fields.counter)),
            .failsafe = flag(0),
            .frame_lost = flag(1),
            .digital_17 = flag(2),
            .digital_18 = flag(3)};
}

void emit_status(const StatusFields& fields, const CanChannelsStatus& status,
                 std::span<std::uint8_t> payload) {
    put(payload, fields.counter, status.counter);
    put(payload, fields.flags[0], status.failsafe ? 1 : 0);
    put(payload, fields.flags[1], status.frame_lost ? 1 : 0);
    put(payload, fields.flags[2], status.digital_17 ? 1 : 0);
    put(payload, fields.flags[3], status.digital_18 ? 1 : 0);
}

struct OriginFields {
    Field link_quality;
    Field channel_count;
    Field source;
    Field age;
};
constexpr OriginFields kTailOrigin{kTailLinkQuality, kTailChannelCount, kTailSource, kTailAge};
constexpr OriginFields kFdOrigin{kFdLinkQuality, kFdChannelCount, kFdSource, kFdAge};

CanChannelsOrigin parse_origin(const OriginFields& fields, std::span<const std::uint8_t> payload) {
    return {.link_quality = static_cast<std::uint8_t>(get(payload, fields.link_quality)),
            .channel_count = static_cast<std::uint8_t>(get(payload, fields.channel_count)),
            .source = static_cast<std::uint8_t>(get(payload, fields.source)),
            .age = get(payload, fields.age)};
}

void emit_origin(const OriginFields& fields, const CanChannelsOrigin& origin,
                 std::span<std::uint8_t> payload) {
    put(payload, fields.link_quality, origin.link_quality);
    put(payload, fields.channel_count, origin.channel_count);
    put(payload, fields.source, origin.source);
    put(payload, fields.age, origin.age);
}

CanChannelsStatus status_of(const ChannelFrame& snapshot, unsigned counter) {
    return {.counter = static_cast<std::uint8_t>(counter),
            .failsafe = snapshot.failsafe,
            .frame_lost = snapshot.frame_lost,
            .digital_17 = snapshot.channel_or(16, kSwitchOffPulse) > kCentrePulse,
            .digital_18 = snapshot.channel_or(17, kSwitchOffPulse) > kCentrePulse};
}

std::uint8_t highest_channel(const ChannelFrame& snapshot) {
    std::uint8_t number = kChannelCount;
    while (number > 0 && !snapshot.has(number - 1U)) {
        --number;
    }
    return number;
}

std::uint16_t age_to_wire(const AgeScale& scale, Instant received, Instant now) {
    // No frame was ever received: the values are presets and have no age.
    if (received == Instant{}) {
        return scale.not_available;
    }
    const Duration step = std::chrono::microseconds(scale.step_microseconds);
    const auto steps = (std::max(now - received, Duration{}) + step / 2) / step;
    return static_cast<std::uint16_t>(
        std::min<std::int64_t>(steps, scale.not_available - std::int64_t{1}));
}

CanChannelsOrigin origin_of(const ChannelFrame& snapshot, const AgeScale& scale, Instant now) {
    return {.link_quality = snapshot.link_quality == kNoLinkQuality
                                ? kLinkQualityNotAvailable
                                : std::min(snapshot.link_quality, kMostLinkQuality),
            .channel_count = highest_channel(snapshot),
            .source = source_to_wire(snapshot.origin),
            .age = age_to_wire(scale, snapshot.received, now)};
}

std::uint8_t listed_id(std::size_t index, std::span<const std::uint8_t> payload) {
    return static_cast<std::uint8_t>(16 * index + get(payload, kCounter));
}

}  // namespace

CanChannelsQuad parse_can_quad(std::span<const std::uint8_t> payload) {
    CanChannelsQuad quad{.status = parse_status(kClassicStatus, payload)};
    for (std::size_t place = 0; place < quad.raw.size(); ++place) {
        quad.raw[place] = get(payload, classic_channel(place));
    }
    return quad;
}

CanChannelsTail parse_can_tail(std::span<const std::uint8_t> payload) {
    CanChannelsTail tail{.status = parse_status(kClassicStatus, payload),
                         .origin = parse_origin(kTailOrigin, payload)};
    for (std::size_t place = 0; place < tail.raw.size(); ++place) {
        tail.raw[place] = get(payload, classic_channel(place));
    }
    return tail;
}

CanChannelsFd parse_can_fd(std::span<const std::uint8_t> payload) {
    CanChannelsFd frame{.status = parse_status(kFdStatus, payload),
                        .origin = parse_origin(kFdOrigin, payload)};
    for (std::size_t channel = 0; channel < frame.raw.size(); ++channel) {
        frame.raw[channel] = get(payload, fd_channel(channel));
    }
    return frame;
}

void emit_can(const CanChannelsQuad& quad, std::span<std::uint8_t> payload) {
    emit_status(kClassicStatus, quad.status, payload);
    for (std::size_t place = 0; place < quad.raw.size(); ++place) {
        put(payload, classic_channel(place), quad.raw[place]);
    }
}

void emit_can(const CanChannelsTail& tail, std::span<std::uint8_t> payload) {
    emit_status(kClassicStatus, tail.status, payload);
    emit_origin(kTailOrigin, tail.origin, payload);
    for (std::size_t place = 0; place < tail.raw.size(); ++place) {
        put(payload, classic_channel(place), tail.raw[place]);
    }
}

void emit_can(const CanChannelsFd& frame, std::span<std::uint8_t> payload) {
    emit_status(kFdStatus, frame.status, payload);
    emit_origin(kFdOrigin, frame.origin, payload);
    for (std::size_t channel = 0; channel < frame.raw.size(); ++channel) {
        put(payload, fd_channel(channel), frame.raw[channel]);
    }
}

std::uint16_t can_channels_crc(const CanChannelsFormat& format, std::size_t index,
                               std::span<const std::uint8_t> payload) {
    const auto data_id = static_cast<std::uint16_t>(kFirstDataId + index);
    if (index == kFdIndex) {
        return p05_crc(payload, data_id);
    }
    return format.crc == CanChannelsCrc::p22 ? p22_crc(payload, listed_id(index, payload))
                                             : p01_crc(payload, data_id);
}

void write_can_channels_crc(const CanChannelsFormat& format, std::size_t index,
                            std::span<std::uint8_t> payload) {
    put(payload, index == kFdIndex ? kFdCrc : kCrc8, can_channels_crc(format, index, payload));
}

std::uint16_t to_wire(const PulseScale& scale, std::optional<Pulse> pulse) {
    if (!pulse) {
        return scale.not_available;
    }
    const std::int32_t above = pulse->eighths() - scale.offset_eighths;
    // Halves go down: FrSky's scale has steps slightly below 0.625 us, so the SBUS value 991 would
    // otherwise come back as 992.
    const std::int32_t nearest = (2 * above + scale.step_eighths - 1) / (2 * scale.step_eighths);
    return static_cast<std::uint16_t>(
        above < 0 ? 0 : std::min<std::int32_t>(nearest, scale.not_available - 1));
}

std::optional<Pulse> from_wire(const PulseScale& scale, std::uint16_t raw) {
    if (raw >= scale.not_available) {
        return std::nullopt;
    }
    return Pulse::from_eighths(scale.offset_eighths + raw * scale.step_eighths);
}

std::uint8_t source_to_wire(Origin origin) {
    const auto* known = std::ranges::find(kSources, origin, &Source::origin);
    return known == kSources.end() ? kSourceNotAvailable : known->raw;
}

Origin source_from_wire(std::uint8_t raw) {
    const auto* known = std::ranges::find(kSources, raw, &Source::raw);
    return known == kSources.end() ? Origin::unknown : known->origin;
}

std::array<CanIdMatch, kIds> can_channels_ids(const CanChannelsFormat& format) {
    std::array<CanIdMatch, kIds> ids{};
    for (std::size_t part = 0; part < format.frame_count(); ++part) {
        ids[part] = {.id = format.base_id + static_cast<std::uint32_t>(format.first_index() + part),
                     .mask = format.extended ? kMostExtendedId : kMostStandardId,
                     .extended = format.extended};
    }
    return ids;
}

CanChannelsEncoder::CanChannelsEncoder(const CanChannelsFormat& format)
    : format_(format), ids_(can_channels_ids(format)) {}

CanFrame CanChannelsEncoder::blank(std::size_t part) const {
    return {.id = ids_[part].id,
            .extended = format_.extended,
            .fd = format_.fd,
            .bit_rate_switch = format_.fd,
            .length = static_cast<std::uint8_t>(format_.frame_length())};
}

void CanChannelsEncoder::continue_from(const Encoder& before) {
    const auto* same = dynamic_cast<const CanChannelsEncoder*>(&before);
    if (same != nullptr) {
        counter_ = same->counter_;
    }
}

std::size_t CanChannelsEncoder::write(const ChannelFrame& snapshot,
                                      std::span<CanFrame, kMostSnapshotFrames> frames,
                                      Instant now) {
    const CanChannelsStatus status = status_of(snapshot, counter_);
    counter_ = (counter_ + 1) % format_.counter_values();
    for (std::size_t part = 0; part < format_.frame_count(); ++part) {
        const std::size_t index = format_.first_index() + part;
        frames[part] = blank(part);
        const auto payload = frames[part].bytes();
        const auto fill = [&](auto& raw, const PulseScale& scale, std::size_t first) {
            for (std::size_t place = 0; place < raw.size(); ++place) {
                raw[place] = to_wire(scale, snapshot.channel(first + place));
            }
        };
        if (index < kTailIndex) {
            CanChannelsQuad quad{.status = status};
            fill(quad.raw, kClassicPulse, index * kChannelsPerQuad);
            emit_can(quad, payload);
        } else if (index == kTailIndex) {
            CanChannelsTail tail{.status = status,
                                 .origin = origin_of(snapshot, kTailAgeScale, now)};
            fill(tail.raw, kClassicPulse, kQuadChannels);
            emit_can(tail, payload);
        } else {
            CanChannelsFd all{.status = status, .origin = origin_of(snapshot, kFdAgeScale, now)};
            fill(all.raw, kFdPulse, 0);
            emit_can(all, payload);
        }
        write_can_channels_crc(format_, index, payload);
    }
    return format_.frame_count();
}

}  // namespace tribus
