#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "core/link_cause.h"
#include "core/number_reservation.h"
#include "core/time.h"
#include "transports/codecs/authenticated/link_keys.h"
#include "transports/codecs/authenticated/messages.h"
#include "transports/codecs/codec.h"

/// Snapshots for receivers that cannot answer. Each has a number that is never used again, in steps
/// of kTimeStep: so it also tells when the snapshot was sent, by the sender's clock.
///   byte 0      as in a snapshot that answers a challenge, and kBroadcastVersion in bits 4 to 7
///   bytes 1 to 3, 12 to 47 as there
///   bytes 4-11  number, low byte first
///   bytes 48-63 Mac of the bytes before it
namespace tribus::authenticated {

/// A sender leaves out at least so many numbers, a day, where it does not know how much time passed
/// since the last one: the machine started again or was suspended. So receivers see that its
/// numbers follow another clock.
inline constexpr std::uint64_t kNewClockNumbers = std::chrono::hours(24) / kTimeStep;

/// Steps of numbers since the zero of instants.
constexpr std::uint64_t clock_step(Instant now) {
    return static_cast<std::uint64_t>(now.time_since_epoch() / kTimeStep);
}

/// Version 0 had another MAC, which two numbers that are the same would have broken: those of a
/// file that was restored or copied.
inline constexpr std::uint8_t kBroadcastVersion = 1;

/// The end that sends. Pure: no descriptor, clock or heap. Thread-bound.
class BroadcastSender {
  public:
    /// 12 hours; the next ones an hour before they are used up.
    static constexpr NumberBlocks kNumbers{.block = std::uint64_t{1} << 32U,
                                           .ahead = std::chrono::hours(1) / kTimeStep};

    explicit BroadcastSender(const Mac& key) : key_(key) {}

    /// Without them it sends nothing. Call before the first `write`. Must outlive it.
    void use_numbers(NumberReservation& numbers) { numbers_ = &numbers; }

    /// Writes a snapshot that leaves at `now`. False if no number is reserved for it.
    bool write(const ChannelFrame& channels, SnapshotMessage& message, Instant now);

  private:
    Mac key_;
    NumberReservation* numbers_ = nullptr;
};

/// The end that receives. It accepts each number once, and none below the highest one, also after
/// it started again. It cannot know how long the first snapshot was on its way: it takes the
/// quickest one since then as one that was not, and tells by how much the others were later, over
/// restarts of the sender too, as long as its numbers follow one clock. Pure: no descriptor, clock
/// or heap. Thread-bound.
class BroadcastReceiver {
  public:
    /// 20 s; the next ones when half of them are used up. So long it may be deaf after it was
    /// killed.
    static constexpr NumberBlocks kNumbers{.block = std::chrono::seconds(20) / kTimeStep,
                                           .ahead = std::chrono::seconds(10) / kTimeStep};
    /// Clocks of two boards drift apart by at most one part in so many.
    static constexpr std::int64_t kDriftParts = 5000;

    /// `old`: of a second key that counts too, while keys are changed.
    BroadcastReceiver(const Mac& key, const std::optional<Mac>& old);

    /// Without them it publishes nothing. Call before the first `next`. Must outlive it.
    void use_numbers(NumberReservation& numbers);

    /// From now on the keys of `fresh` count. Order and quickest snapshots stay.
    void use_keys_of(const BroadcastReceiver& fresh);

    /// Takes a message that arrived at `received`. `received` of what it publishes is the time
    /// since which the values may have been old.
    std::optional<ChannelFrame> next(std::span<const std::uint8_t> message, Instant received);

    /// Why messages were refused: "no_key", which are none of a link with a key; "forged", whose
    /// MAC is wrong; "replayed", whose number may have been used; "not_stored", whose number is not
    /// reserved yet; "other_version", which another version of tribus sends.
    std::span<const NamedCount> rejected() const { return rejected_; }
    /// The kind of the latest message: `garbled` if it was not refused.
    LinkCause why_refused() const { return why_refused_; }
    /// Says so if the latest message was one of another version. Returns the length.
    std::size_t write_fault(std::span<char> text) const;

  private:
    enum Refusal : std::size_t { kNoKey, kForged, kReplayed, kNotStored, kOtherVersion, kRefusals };
    /// The snapshot that was the quickest, as far as clocks that drift can tell.
    struct Quickest {
        std::uint64_t number = 0;
        Instant received{};
    };
    /// A key, and what is known of its snapshots.
    struct Key {
        explicit Key(const Mac& its_mac);

        Mac mac;
        std::uint32_t id = 0;  ///< of its numbers
        NumberReservation* numbers = nullptr;
        std::optional<Quickest> quickest{};

        std::uint64_t next() const { return numbers != nullptr ? numbers->next() : 0; }
        Duration delay_of(std::uint64_t number, Instant received);
    };

    std::optional<ChannelFrame> refuse(Refusal refusal, LinkCause cause);

    Key key_;
    std::optional<Key> old_;
    bool other_version_ = false;  ///< the latest message
    LinkCause why_refused_ = LinkCause::garbled;
    std::array<NamedCount, kRefusals> rejected_{
        {{"no_key"}, {"forged"}, {"replayed"}, {"not_stored"}, {"other_version"}}};
};

}  // namespace tribus::authenticated
