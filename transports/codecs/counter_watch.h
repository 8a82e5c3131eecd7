#pragma once

#include <cstdint>
#include <optional>

#include "core/time.h"

namespace tribus {

/// Judges the counter that a sender raises with each frame or snapshot, which tells a live sender
/// from one that hangs, from two senders in turn, and from a queue that empties late (can.md 4.4).
/// Pure and thread-bound; no heap.
class CounterWatch {
  public:
    /// So often in a row the counter must go on rightly before anything is believed: at the start
    /// and after whatever makes the sender doubtful.
    static constexpr unsigned kProof = 2;

    struct Limits {
        std::uint64_t values = 0;     ///< the counter goes from 0 to one less than this
        std::uint64_t most_step = 1;  ///< of one advance: more than 1 where frames may be lost
        Duration silence{};           ///< after more than this the counter says nothing any more
    };

    enum class Verdict : std::uint8_t {
        good,
        unconfirmed,  ///< it may go on rightly, but proof is still missing
        repeated,     ///< the same counter with the same content
        conflict,     ///< the same counter with another content
        jump,         ///< beyond the most step, or a value that the counter never has
    };

    explicit CounterWatch(const Limits& limits) : limits_(limits) {}

    /// `same_content`: it equals what was taken before.
    Verdict take(std::uint64_t count, bool same_content, Instant received);
    /// Something else makes the sender doubtful: all proof is due again.
    void doubt() { proof_ = 0; }

  private:
    Verdict doubtful(Verdict verdict);

    Limits limits_;
    /// What was taken last, if the counter can have that value.
    std::optional<std::uint64_t> count_;
    Instant received_{};
    unsigned proof_ = 0;
};

}  // namespace tribus
