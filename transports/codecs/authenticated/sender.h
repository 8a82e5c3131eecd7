#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "core/random_seed.h"
#include "core/time.h"
#include "transports/codecs/authenticated/messages.h"

namespace tribus::authenticated {

/// The end of an authenticated link that sends snapshots. Each answers the newest challenge of the
/// receiver; without one there is none. Pure: no descriptor, clock or heap. Thread-bound.
class Sender {
  public:
    /// It asks for a challenge that often, if the newest one is older than `kHelloAfter` or there
    /// is none: each time so much earlier or later that nobody can foresee the next hello.
    static constexpr Duration kHelloPeriod = std::chrono::milliseconds(100);
    static constexpr Duration kHelloJitter = std::chrono::milliseconds(25);
    static constexpr Duration kHelloAfter = std::chrono::milliseconds(200);

    /// `seed`: another one after each start.
    Sender(const LinkMacs& macs, const RandomSeed& seed);

    /// Begins a new session. Call before the first message.
    void use_seed(const RandomSeed& seed);
    /// Takes a message that arrived at `received`. Returns whether it is a new challenge of the
    /// key's holder to this sender. One that is not newer than the one before changes nothing: who
    /// repeats it cannot make old values seem young.
    bool hear(std::span<const std::uint8_t> message, Instant received);
    /// Writes a hello that leaves at `now`. False if none is due.
    bool write_hello(HelloMessage& message, Instant now);
    /// Writes a snapshot that leaves at `now`. False without a challenge, or if the newest is so
    /// old (0.65 s) that the receiver could not tell the age of the snapshot.
    bool write(const ChannelFrame& channels, SnapshotMessage& message, Instant now);

  private:
    Duration pause_behind_hello();

    LinkMacs macs_;
    Mac random_;
    std::uint32_t session_;
    std::optional<Challenge> challenge_;
    std::optional<SnapshotMac> answers_;  ///< of `challenge_`
    Instant challenged_{};
    std::uint16_t counter_ = 0;
    std::optional<Instant> next_hello_;
    std::uint32_t hellos_ = 0;
};

}  // namespace tribus::authenticated
