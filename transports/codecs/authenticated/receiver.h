#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/authenticated/messages.h"
#include "transports/codecs/codec.h"

namespace tribus::authenticated {

/// The end of an authenticated link that receives snapshots. It sends challenges, and publishes
/// only what answers one of them: proof that the key's holder sent it after that challenge. Nothing
/// on the way, kept for however long, can be published twice or seem younger than it is. Pure: no
/// descriptor, clock or heap. Thread-bound.
class Receiver {
  public:
    /// Time between two challenges.
    static constexpr Duration kChallengePeriod = std::chrono::milliseconds(100);
    /// A challenge counts for so long. Snapshots are older than that if they come later.
    static constexpr Duration kChallengeLasts = std::chrono::seconds(1);
    /// A sender that has been silent for so long may have started again. Until then the snapshots
    /// of another one with the same key stop both: two senders must not take turns.
    static constexpr Duration kSessionSilence = std::chrono::milliseconds(250);

    /// `life`: random, another one after each start.
    Receiver(const LinkMacs& macs, std::uint32_t life);

    /// Writes the challenge that leaves at `now`. `nonce`: random, never used before.
    void challenge(const Nonce& nonce, ChallengeMessage& message, Instant now);
    /// Takes a message that arrived at `received`. `received` of what it publishes is the time
    /// since which the values may have been old: that of the answered challenge, with the time for
    /// which the sender held it, less the age that the values had there. So the age is never told
    /// too low, and too high by at most the way of the challenge and 0.1 % of the time held.
    std::optional<ChannelFrame> next(std::span<const std::uint8_t> message, Instant received);

    /// Why messages were refused: "length"; "no_challenge", which answers none that still counts;
    /// "forged", whose MAC is wrong; "replayed", which is not newer than the one before;
    /// "two_senders"; "impossible", which the sender held longer than the challenge exists.
    std::span<const NamedCount> rejected() const { return rejected_; }

  private:
    enum Refusal : std::size_t {
        kLength,
        kNoChallenge,
        kForged,
        kReplayed,
        kTwoSenders,
        kImpossible,
        kRefusals,
    };
    struct Asked {
        Challenge challenge;
        Instant sent{};
    };
    /// As many as count at the same time, and one.
    static constexpr std::size_t kMostAsked = kChallengeLasts / kChallengePeriod + 1;

    std::optional<ChannelFrame> refuse(Refusal refusal);
    const Asked* asked(std::uint8_t number, Instant received) const;
    std::optional<Refusal> fault_of_order(const SnapshotHead& head, std::uint32_t number,
                                          Instant received);

    LinkMacs macs_;
    std::uint32_t life_;
    std::uint32_t asked_count_ = 0;  ///< also the number of the next challenge
    std::array<Asked, kMostAsked> asked_{};

    bool bound_ = false;
    std::uint32_t session_ = 0;
    std::uint32_t number_ = 0;
    std::uint16_t counter_ = 0;
    Instant accepted_{};
    Instant conflict_until_{};

    std::array<NamedCount, kRefusals> rejected_{
        {{"length"}, {"no_challenge"}, {"forged"}, {"replayed"}, {"two_senders"}, {"impossible"}}};
};

}  // namespace tribus::authenticated
