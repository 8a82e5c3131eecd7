#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "core/link_cause.h"
#include "core/random_seed.h"
#include "core/time.h"
#include "transports/codecs/authenticated/messages.h"
#include "transports/codecs/codec.h"

namespace tribus::authenticated {

/// The end of an authenticated link that receives snapshots. It answers senders with challenges,
/// and publishes only what answers one of these: proof that the key's holder sent it after that
/// challenge. Nothing on the way, kept for however long, can be published twice or seem younger
/// than it is. It says nothing to those who do not have the key. Pure: no descriptor, clock or
/// heap. Thread-bound.
class Receiver {
  public:
    /// Least time between two challenges.
    static constexpr Duration kChallengePeriod = std::chrono::milliseconds(50);
    /// Hellos that somebody repeats are answered too, since the sender's own looks the same: one
    /// for each such time, and so many at once. The latter half is only for sessions that are not
    /// among those answered lately.
    static constexpr Duration kAnswerPeriod = std::chrono::microseconds(500);
    static constexpr int kAnswersAtOnce = 64;
    /// A challenge counts for so long. Snapshots are older than that if they come later.
    static constexpr Duration kChallengeLasts = std::chrono::seconds(1);
    /// A sender that has been silent for so long may have started again. Until then the snapshots
    /// of another one with the same key stop both: two senders must not take turns.
    static constexpr Duration kSessionSilence = std::chrono::milliseconds(250);

    /// `old`: of a second key that counts too, while keys are changed. `seed`: random, another one
    /// after each start.
    Receiver(const LinkMacs& macs, const std::optional<LinkMacs>& old, const RandomSeed& seed);

    /// Begins a new life. Call before the first `next`.
    void use_seed(const RandomSeed& seed);
    /// Each challenge has bytes of it, too: a receiver whose memory was restored asks anew.
    void use_random(RandomSource random) { fresh_ = random; }
    /// From now on the keys of `fresh` count. Challenges and order go on.
    void use_keys_of(const Receiver& fresh);
    /// Writes the challenge for the first of those who wait, which leaves at `now`. False if none
    /// is due yet.
    bool answer(ChallengeMessage& message, Instant now);
    /// Nobody waits any more. They ask again.
    void forget_askers() { askers_count_ = 0; }
    /// Takes a message that arrived at `received`. `received` of what it publishes is the time
    /// since which the values may have been old: that of the answered challenge, with the time for
    /// which the sender held it, less the age that the values had there. So the age is never told
    /// too low, and too high by at most the way of the challenge and 0.1 % of the time held.
    std::optional<ChannelFrame> next(std::span<const std::uint8_t> message, Instant received);

    /// Why messages were refused: "no_key", which are none of a link with a key; "no_challenge",
    /// which answer none that still counts; "forged", whose MAC is wrong; "replayed", which are not
    /// newer than the one before; "two_senders"; "impossible", which the sender held longer than
    /// the challenge exists.
    std::span<const NamedCount> rejected() const { return rejected_; }
    /// The kind of the latest message: `garbled` if it was not refused.
    LinkCause why_refused() const { return why_refused_; }

  private:
    enum Refusal : std::size_t {
        kNoKey,
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
    /// Who comes first. A hello may be a recording; a snapshot that counts is none.
    enum class Rank : std::uint8_t { answered_lately, says_hello, sends_snapshots };
    /// A sender that waits for an answer, and its key.
    struct Asker {
        std::uint32_t session = 0;
        bool old_key = false;
        Rank rank = Rank::says_hello;
    };
    static constexpr std::size_t kMostAskers = 64;
    static constexpr std::size_t kAnsweredLately = 32;
    /// More than count at the same time; the low byte of a number gives the place.
    static constexpr std::size_t kMostAsked = 32;
    static_assert(kMostAsked > kChallengeLasts / kChallengePeriod + 1);

    std::optional<ChannelFrame> refuse(Refusal refusal);
    void take_hello(std::span<const std::uint8_t> message);
    std::optional<ChannelFrame> take_snapshot(std::span<const std::uint8_t> message,
                                              Instant received);
    const Asked& newest() const { return asked_[(asked_count_ - 1) % kMostAsked]; }
    const Asked* asked(std::uint8_t number, Instant received) const;
    /// Whose MAC `is_right` finds right: false for the key, true for the old one.
    /// The MACs of one session's answers to one challenge.
    struct Answers {
        std::uint32_t number = 0;
        std::uint32_t session = 0;
        SnapshotMac mac;
    };
    /// The MACs by one key, and those of the answers that came last.
    struct Key {
        LinkMacs macs;
        std::optional<Answers> answers{};

        SnapshotMac& mac_of_answers(const Challenge& challenge, std::uint32_t session);
    };
    template <class IsRight>
    std::optional<bool> key_of(const IsRight& is_right);
    void ask_anew(Instant now);
    void wait(const Asker& asker);
    std::optional<Asker> next_asker(Instant now);
    bool may_answer_hello(Rank rank, Instant now);
    std::optional<Refusal> fault_of_order(const SnapshotHead& head, std::uint32_t number,
                                          Instant received);

    Key key_;
    std::optional<Key> old_;
    Mac random_;
    RandomSource fresh_ = nullptr;
    std::uint32_t life_ = 0;
    std::uint32_t asked_count_ = 0;  ///< also the number of the next challenge
    std::array<Asked, kMostAsked> asked_{};
    std::array<Asker, kMostAskers> askers_{};
    std::size_t askers_count_ = 0;
    /// Of the hellos that were answered last. Above 24 bits: none.
    std::array<std::uint32_t, kAnsweredLately> answered_sessions_;
    std::size_t answered_count_ = 0;
    Instant answers_paid_{};  ///< the answers of hellos so far count until then

    bool bound_ = false;
    std::uint32_t session_ = 0;
    std::uint32_t number_ = 0;
    std::uint16_t counter_ = 0;
    Instant accepted_{};
    Instant conflict_until_{};
    LinkCause why_refused_ = LinkCause::garbled;

    std::array<NamedCount, kRefusals> rejected_{
        {{"no_key"}, {"no_challenge"}, {"forged"}, {"replayed"}, {"two_senders"}, {"impossible"}}};
};

}  // namespace tribus::authenticated
