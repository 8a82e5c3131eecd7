#include "transports/codecs/authenticated/messages.h"

#include <algorithm>
#include <optional>

namespace tribus::authenticated {
namespace {

constexpr std::size_t kNumberAt = 4;
constexpr std::size_t kNonceAt = 8;
constexpr std::size_t kQualityAt = 1;
constexpr std::size_t kAgeAt = 2;
constexpr std::size_t kSessionAt = 4;
constexpr std::size_t kChallengeAt = 7;
constexpr std::size_t kHeldAt = 8;
constexpr std::size_t kCounterAt = 10;
constexpr std::size_t kChannelsAt = 12;
static_assert(kChannelsAt + 2 * kChannelCount == kSnapshotBodyBytes);

constexpr std::uint16_t kAbsent = 0xFFFF;
constexpr std::uint8_t kMostLinkQuality = 100;
constexpr std::uint8_t kFailsafeBit = 1;
constexpr std::uint8_t kFrameLostBit = 2;

void put(std::span<std::uint8_t> bytes, std::size_t at, std::size_t count, std::uint32_t number) {
    for (std::size_t byte = 0; byte < count; ++byte) {
        bytes[at + byte] = static_cast<std::uint8_t>(number >> (8 * byte));
    }
}

std::uint32_t get(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t count) {
    std::uint32_t number = 0;
    for (std::size_t byte = 0; byte < count; ++byte) {
        number |= std::uint32_t{bytes[at + byte]} << (8 * byte);
    }
    return number;
}

std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t at) {
    return static_cast<std::uint16_t>(get(bytes, at, 2));
}

std::uint16_t word_of(std::optional<Pulse> pulse) {
    return pulse ? static_cast<std::uint16_t>(std::max(pulse->eighths(), 0)) : kAbsent;
}

std::optional<Pulse> pulse_of(std::uint16_t word) {
    return word == kAbsent ? std::nullopt : std::optional(Pulse::from_eighths(word));
}

}  // namespace

std::uint16_t held_steps(Duration held) {
    const std::int64_t steps = std::max(held, Duration{}) / kTimeStep;
    return static_cast<std::uint16_t>(std::min<std::int64_t>(steps, kNotTold));
}

std::uint16_t age_steps(Duration age) {
    return held_steps(std::max(age, Duration{}) + kTimeStep - Duration(1));
}

SessionBytes session_bytes(std::uint32_t session) {
    SessionBytes bytes{};
    put(bytes, 0, bytes.size(), session);
    return bytes;
}

AnsweredBytes answered_bytes(const Nonce& nonce, std::uint32_t session) {
    AnsweredBytes bytes{};
    std::ranges::copy(nonce, bytes.begin());
    put(bytes, nonce.size(), kSessionBytes, session);
    return bytes;
}

void emit_hello(std::uint32_t session, HelloMessage& message) {
    message = {};
    put(message, 0, kSessionBytes, session);
}

std::uint32_t parse_hello(std::span<const std::uint8_t> message) {
    return get(message, 0, kSessionBytes);
}

void emit(const Challenge& challenge, ChallengeMessage& message) {
    put(message, 0, 4, challenge.life);
    put(message, kNumberAt, 4, challenge.number);
    std::ranges::copy(challenge.nonce, message.begin() + kNonceAt);
}

Challenge parse_challenge(std::span<const std::uint8_t> message) {
    Challenge challenge{.life = get(message, 0, 4), .number = get(message, kNumberAt, 4)};
    std::ranges::copy(message.subspan(kNonceAt, challenge.nonce.size()), challenge.nonce.begin());
    return challenge;
}

void emit(const SnapshotHead& head, const ChannelFrame& channels, SnapshotMessage& message) {
    message[0] = static_cast<std::uint8_t>((channels.failsafe ? kFailsafeBit : 0) |
                                           (channels.frame_lost ? kFrameLostBit : 0));
    message[kQualityAt] = channels.link_quality;
    put(message, kAgeAt, 2, head.age);
    put(message, kSessionAt, kSessionBytes, head.session);
    message[kChallengeAt] = head.challenge;
    put(message, kHeldAt, 2, head.held);
    put(message, kCounterAt, 2, head.counter);
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        put(message, kChannelsAt + 2 * channel, 2, word_of(channels.channel(channel)));
    }
}

SnapshotHead parse_head(std::span<const std::uint8_t> message) {
    return {.session = get(message, kSessionAt, kSessionBytes),
            .challenge = message[kChallengeAt],
            .held = word_at(message, kHeldAt),
            .counter = word_at(message, kCounterAt),
            .age = word_at(message, kAgeAt)};
}

ChannelFrame parse_channels(std::span<const std::uint8_t> message) {
    ChannelFrame frame;
    frame.failsafe = (message[0] & kFailsafeBit) != 0;
    frame.frame_lost = (message[0] & kFrameLostBit) != 0;
    frame.origin = Origin::can;
    const std::uint8_t quality = message[kQualityAt];
    frame.link_quality = quality <= kMostLinkQuality ? quality : kNoLinkQuality;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        frame.set(channel, pulse_of(word_at(message, kChannelsAt + 2 * channel)));
    }
    return frame;
}

}  // namespace tribus::authenticated
