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
///   bytes 0 to 3, 12 to 47 as in a snapshot that answers a challenge
///   bytes 4-11  number, low byte first
///   bytes 48-63 SnapshotMac of the low 16 bits of the number and the bytes before it; its key is
///               made of the other 48 bits
namespace tribus::authenticated {

/// A sender leaves out at least so many numbers, a day, where it does not know how much time passed
/// since the last one: the machine started again or was suspended. So receivers see that its
/// numbers follow another clock.
inline constexpr std::uint64_t kNewClockNumbers = std::chrono::hours(24) / kTimeStep;

/// Steps of numbers since the zero of instants.
constexpr std::uint64_t clock_step(Instant now) {
    return static_cast<std::uint64_t>(now.time_since_epoch() / kTimeStep);
}

/// The MACs of broadcast snapshots by one key. Thread-bound.
class BroadcastMacs {
  public:
    explicit BroadcastMacs(const Mac& keys) : keys_(keys) {}

    MacBytes of(std::uint64_t number, std::span<const std::uint8_t> body) {
        return mac_for(number).of(static_cast<std::uint16_t>(number), body);
    }
    bool is_right(std::span<const std::uint8_t> told, std::uint64_t number,
                  std::span<const std::uint8_t> body) {
        return mac_for(number).is_right(told, static_cast<std::uint16_t>(number), body);
    }

  private:
    SnapshotMac& mac_for(std::uint64_t number);

    Mac keys_;
    std::optional<std::uint64_t> key_number_{};  ///< the high 48 bits
    std::optional<SnapshotMac> mac_{};
};

/// The end that sends. Pure: no descriptor, clock or heap. Thread-bound.
class BroadcastSender {
  public:
    /// 12 hours; the next ones an hour before they are used up.
    static constexpr NumberBlocks kNumbers{.block = std::uint64_t{1} << 32U,
                                           .ahead = std::chrono::hours(1) / kTimeStep};

    explicit BroadcastSender(const Mac& keys) : macs_(keys) {}

    /// Without them it sends nothing. Call before the first `write`. Must outlive it.
    void use_numbers(NumberReservation& numbers) { numbers_ = &numbers; }

    /// Writes a snapshot that leaves at `now`. False if no number is reserved for it.
    bool write(const ChannelFrame& channels, SnapshotMessage& message, Instant now);

  private:
    BroadcastMacs macs_;
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
    BroadcastReceiver(const Mac& keys, const std::optional<Mac>& old);

    /// Without them it publishes nothing. Call before the first `next`. Must outlive it.
    void use_numbers(NumberReservation& numbers) { numbers_ = &numbers; }

    /// From now on the keys of `fresh` count. Order and quickest snapshot stay.
    void use_keys_of(const BroadcastReceiver& fresh) {
        macs_ = fresh.macs_;
        old_ = fresh.old_;
    }

    /// Takes a message that arrived at `received`. `received` of what it publishes is the time
    /// since which the values may have been old.
    std::optional<ChannelFrame> next(std::span<const std::uint8_t> message, Instant received);

    /// Why messages were refused: "no_key", which are none of a link with a key; "forged", whose
    /// MAC is wrong; "replayed", whose number may have been used; "not_stored", whose number is not
    /// reserved yet.
    std::span<const NamedCount> rejected() const { return rejected_; }
    /// The kind of the latest message: `garbled` if it was not refused.
    LinkCause why_refused() const { return why_refused_; }

  private:
    enum Refusal : std::size_t { kNoKey, kForged, kReplayed, kNotStored, kRefusals };

    std::optional<ChannelFrame> refuse(Refusal refusal, LinkCause cause);
    Duration delay_of(std::uint64_t number, Instant received);

    BroadcastMacs macs_;
    std::optional<BroadcastMacs> old_;
    NumberReservation* numbers_ = nullptr;
    /// The snapshot that was the quickest, as far as clocks that drift can tell.
    struct Quickest {
        std::uint64_t number = 0;
        Instant received{};
    };
    std::optional<Quickest> quickest_;
    LinkCause why_refused_ = LinkCause::garbled;
    std::array<NamedCount, kRefusals> rejected_{
        {{"no_key"}, {"forged"}, {"replayed"}, {"not_stored"}}};
};

}  // namespace tribus::authenticated
