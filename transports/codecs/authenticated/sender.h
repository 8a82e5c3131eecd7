#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/authenticated/messages.h"

namespace tribus::authenticated {

/// The end of an authenticated link that sends snapshots. Each answers the newest challenge of the
/// receiver; without one there is none. Pure: no descriptor, clock or heap. Thread-bound.
class Sender {
  public:
    /// `session`: random, 24 bits, another one after each start.
    Sender(const LinkMacs& macs, std::uint32_t session);

    /// Takes a message that arrived at `received`. Returns whether it is a new challenge of the
    /// key's holder. One that is not newer than the one before changes nothing: who repeats it
    /// cannot make old values seem young.
    bool hear(std::span<const std::uint8_t> message, Instant received);
    /// Writes a snapshot that leaves at `now`. False without a challenge, or if the newest is so
    /// old (0.65 s) that the receiver could not tell the age of the snapshot.
    bool write(const ChannelFrame& channels, SnapshotMessage& message, Instant now);

  private:
    LinkMacs macs_;
    std::uint32_t session_;
    std::optional<Challenge> challenge_;
    Instant challenged_{};
    std::uint16_t counter_ = 0;
};

}  // namespace tribus::authenticated
