#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/time.h"

namespace tribus {

/// Judges the counter that a sender raises with each frame or snapshot, which tells a live sender
/// from one that hangs, from two senders, from a queue that empties late (docs/protocols/can.md,
/// "Native format"), and from old frames that something repeats in a ring.
///
/// A ring shows itself where it begins again: its counter is suddenly further on than the time
/// since the frame before allows. After that nothing is believed until the counter has gone on,
/// without another such break, further than any ring of at most `kLongestRing` frames can. A ring
/// as long as the counter's whole range cannot be told from a live sender. A sender that restarts
/// within `silence` pays the same; after a pause that its counter fits, or after `silence`, it does
/// not. Pure and thread-bound; no heap.
class CounterWatch {
  public:
    /// So often in a row the counter must go on rightly before anything is believed: at the start
    /// and after whatever makes the sender doubtful.
    static constexpr unsigned kProof = 2;
    /// Counts that must pass after a break, or all that the counter has if those are less.
    static constexpr std::uint64_t kLongestRing = 256;
    /// A second break within so many counts of the first makes the proof as long as what lay
    /// between them: a second sender that is rare, or a longer ring.
    static constexpr std::uint64_t kRemembered = 512;

    struct Limits {
        std::uint64_t values = 0;     ///< the counter goes from 0 to one less than this
        std::uint64_t most_step = 1;  ///< of one advance: more than 1 where frames may be lost
        Duration silence{};           ///< after more than this the counter says nothing any more
        unsigned proof = kProof;      ///< 0: what comes first is believed
    };

    enum class Verdict : std::uint8_t {
        good,
        unconfirmed,  ///< it may go on rightly, but proof is still missing
        repeated,     ///< the same counter with the same content
        conflict,     ///< the same counter with another content
        jump,         ///< beyond the most step, further than time allows, or never a value of it
    };

    explicit CounterWatch(const Limits& limits) : limits_(limits) {}

    /// `same_content`: it equals what was taken before.
    Verdict take(std::uint64_t count, bool same_content, Instant received);
    /// Something else makes the sender doubtful: `proof` is due again.
    void doubt() { proof_ = 0; }
    /// Something else shows a second sender or a ring: the long proof is due.
    void distrust();

  private:
    Verdict begin();
    Verdict advance(std::uint64_t step);
    bool time_allows(std::uint64_t step, Duration elapsed) const;
    void learn_pace(std::uint64_t step, Duration elapsed);

    Limits limits_;
    /// What was taken last, if the counter can have that value.
    std::optional<std::uint64_t> count_;
    Instant received_{};
    unsigned proof_ = 0;
    std::uint64_t due_ = 0;            ///< counts that must still pass after a break
    std::uint64_t run_ = kRemembered;  ///< counts since the last break, at most this
    Duration pace_{};                  ///< of one count, about; zero: not known
    Duration spare_{};                 ///< how much later than its pace the last frame came
};

}  // namespace tribus
