#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "transports/codecs/authenticated/receiver.h"
#include "transports/codecs/authenticated/sender.h"

/// Both ends of an authenticated link, and somebody on the way. Keys and MACs of the literal bytes
/// were computed with Python: hmac, AES and CMAC of its package cryptography, and Poly1305 by its
/// definition.
namespace tribus::test::authenticated_link {

using namespace authenticated;
using namespace std::chrono_literals;

inline constexpr std::string_view kLink = "can 0x300 boat";
inline constexpr std::uint32_t kSession = 0x0A0B0C;
inline constexpr std::uint32_t kOtherSession = 0x0A0B0D;
inline constexpr RandomSeed kSeed{0x20, 0x21, 0x22, 0x23, 0x24, 0x25, 0x26, 0x27,
                                  0x28, 0x29, 0x2A, 0x2B, 0x2C, 0x2D, 0x2E, 0x2F};
inline constexpr RandomSeed kOtherSeed{1, 2, 3};

/// A sender's session is the first bytes of its seed.
constexpr RandomSeed seed_of(std::uint32_t session) {
    return {static_cast<std::uint8_t>(session), static_cast<std::uint8_t>(session >> 8U),
            static_cast<std::uint8_t>(session >> 16U)};
}

inline SecretKey counted_secret() {
    SecretKey secret{};
    for (std::size_t i = 0; i < secret.size(); ++i) {
        secret[i] = static_cast<std::uint8_t>(i);
    }
    return secret;
}

inline Instant at(Duration time) {
    return Instant{} + 1h + time;
}

template <class Message>
std::vector<std::uint8_t> copy_of(const Message& message) {
    return {message.begin(), message.end()};
}

inline constexpr std::string_view kHelloDigits = "0c0b0a000000000042626cb5f71253f64d6ba7020bbb780b";
inline constexpr std::string_view kChallengeDigits =
    "3de0fc3d0000000098729a45e630923943db1cf2d1e4f444d570af281a9eb78d";
inline constexpr std::string_view kSnapshotDigits =
    "006196000c0b0a00c8000000401fd0206022f02380251027a028302ac02b502de02e7030003290332035b036"
    "ffffffff9e74ca18abfa14616ce5922351556bd0";
/// The one after it, 2 ms later.
inline constexpr std::string_view kNextSnapshotDigits =
    "006196000c0b0a0090010100401fd0206022f02380251027a028302ac02b502de02e7030003290332035b0"
    "36ffffffff602d8a8563ea0aad649461d76b3e43aa";

/// 16 channels from 1000 us in steps of 50 us, good, link quality 97 %.
inline ChannelFrame sticks(Instant received) {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < 16; ++channel) {
        frame.set(channel,
                  Pulse::from_microseconds(1000 + 50 * static_cast<std::int64_t>(channel)));
    }
    frame.failsafe = false;
    frame.frame_lost = false;
    frame.link_quality = 97;
    frame.received = received;
    return frame;
}

/// A link with everything that its ends sent.
class AuthenticatedLink : public ::testing::Test {
  protected:
    static LinkMacs macs() { return {counted_secret(), kLink}; }

    static std::vector<std::uint8_t> hello(std::uint32_t session) {
        Sender sender(macs(), seed_of(session));
        HelloMessage message{};
        EXPECT_TRUE(sender.write_hello(message, at(0ms)));
        return copy_of(message);
    }
    static std::vector<std::uint8_t> answer(Receiver& receiver, Instant now) {
        ChallengeMessage message{};
        return receiver.answer(message, now) ? copy_of(message) : std::vector<std::uint8_t>{};
    }
    /// The answer of the receiver to a hello.
    static std::vector<std::uint8_t> challenge(Receiver& receiver, Instant now,
                                               std::uint32_t session = kSession) {
        EXPECT_FALSE(receiver.next(hello(session), now));
        return answer(receiver, now);
    }
    std::vector<std::uint8_t> challenge(Instant now, std::uint32_t session = kSession) {
        return challenge(receiver_, now, session);
    }
    static std::vector<std::uint8_t> snapshot(Sender& sender, Instant now, Duration age = 0ms) {
        SnapshotMessage message{};
        return sender.write(sticks(now - age), message, now) ? copy_of(message)
                                                             : std::vector<std::uint8_t>{};
    }
    /// A challenge that arrives at once.
    void ask(Instant now) { ASSERT_TRUE(sender_.hear(challenge(now), now)); }
    std::uint64_t refused(std::string_view name) const {
        const auto counts = receiver_.rejected();
        const auto found = std::ranges::find(counts, name, &NamedCount::name);
        return found == counts.end() ? 0 : found->count;
    }

    Receiver receiver_{macs(), std::nullopt, kSeed};
    Sender sender_{macs(), seed_of(kSession)};
};

}  // namespace tribus::test::authenticated_link
