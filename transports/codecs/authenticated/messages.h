#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/authenticated/link_keys.h"

/// The messages of an authenticated link (docs/protocols/authenticated.md, "Messages"). Words have
/// the low byte first; each message ends with its MAC. Lengths are those that an FD frame can have,
/// and tell the messages apart.
namespace tribus::authenticated {

/// From the sender: asks for a challenge.
///   bytes 0-2   session: random, another one after each start of the sender
///   bytes 3-7   zero
///   bytes 8-23  MAC of the bytes before it
inline constexpr std::size_t kHelloBytes = 24;
inline constexpr std::size_t kHelloBodyBytes = kHelloBytes - kMacBytes;
/// From the receiver. The nonce is random and 64 bits long.
///   bytes 0-3   life: random, another one after each start of the receiver
///   bytes 4-7   number: one more than that of the challenge before
///   bytes 8-15  nonce
///   bytes 16-31 MAC of the session of the sender that is asked, 3 bytes, and the bytes before it
inline constexpr std::size_t kChallengeBytes = 32;
inline constexpr std::size_t kChallengeBodyBytes = kChallengeBytes - kMacBytes;
/// From the sender.
///   byte 0      failsafe, frame lost, then zeros
///   byte 1      link quality, 0 to 100 %; 255: none
///   bytes 2, 3  age of the values when they were sent, in 10 us; 65535: none or more
///   bytes 4-6   session
///   byte 7      low byte of the number of the challenge that it answers
///   bytes 8, 9  time from the arrival of that challenge until now, in 10 us
///   bytes 10, 11 counter of the snapshots of this session, from 0; 0 follows 65535
///   bytes 12-47 18 channels in 0.125 us; 65535: absent
///   bytes 48-63 SnapshotMac of the counter and the bytes before it
inline constexpr std::size_t kSnapshotBytes = 64;
inline constexpr std::size_t kSnapshotBodyBytes = kSnapshotBytes - kMacBytes;

using HelloMessage = std::array<std::uint8_t, kHelloBytes>;
using ChallengeMessage = std::array<std::uint8_t, kChallengeBytes>;
using SnapshotMessage = std::array<std::uint8_t, kSnapshotBytes>;
using Nonce = std::array<std::uint8_t, 8>;

inline constexpr Duration kTimeStep = std::chrono::microseconds(10);
/// Ages and times above the highest word but one are not told.
inline constexpr std::uint16_t kNotTold = 0xFFFF;
inline constexpr std::uint32_t kSessionMask = 0xFF'FFFF;
inline constexpr std::size_t kSessionBytes = 3;
using SessionBytes = std::array<std::uint8_t, kSessionBytes>;

/// The content of a challenge.
struct Challenge {
    std::uint32_t life = 0;
    std::uint32_t number = 0;
    Nonce nonce{};
};

/// The part of a snapshot before its channels.
struct SnapshotHead {
    std::uint32_t session = 0;      ///< 24 bits
    std::uint8_t challenge = 0;     ///< low byte of its number
    std::uint16_t held = kNotTold;  ///< steps of kTimeStep
    std::uint16_t counter = 0;
    std::uint16_t age = kNotTold;  ///< steps of kTimeStep
};

/// Steps of kTimeStep; kNotTold if there are too many. An age is rounded up and a time held down:
/// the values may seem older than they are, and never younger.
std::uint16_t age_steps(Duration age);
std::uint16_t held_steps(Duration held);

/// A session as it is sent.
SessionBytes session_bytes(std::uint32_t session);

/// The key of a SnapshotMac is made of this: the nonce, then the session as it is sent.
using AnsweredBytes = std::array<std::uint8_t, std::tuple_size_v<Nonce> + kSessionBytes>;
AnsweredBytes answered_bytes(const Nonce& nonce, std::uint32_t session);

/// Write and read everything but the MAC. The lengths are checked before.
void emit_hello(std::uint32_t session, HelloMessage& message);
std::uint32_t parse_hello(std::span<const std::uint8_t> message);
void emit(const Challenge& challenge, ChallengeMessage& message);
Challenge parse_challenge(std::span<const std::uint8_t> message);
void emit(const SnapshotHead& head, const ChannelFrame& channels, SnapshotMessage& message);
SnapshotHead parse_head(std::span<const std::uint8_t> message);
/// Channels, flags and link quality. `received` stays as it is.
ChannelFrame parse_channels(std::span<const std::uint8_t> message);

}  // namespace tribus::authenticated
