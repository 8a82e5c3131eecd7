#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/time.h"

namespace tribus {

/// Checks the counter that a sender increases with each frame or snapshot. It distinguishes a live
/// sender from one that hangs, from two senders, from a queue that empties late
/// (docs/protocols/can.md, "Native format"), and from a ring: old frames that are replayed in a
/// loop.
///
/// A ring shows where it starts again: its counter jumps further than the time since the last frame
/// allows. After such a break nothing is accepted until the counter has advanced, without another
/// break, by more than any ring of up to `kLongestRing` frames can. A ring as long as the counter's
/// range cannot be told from a live sender. A sender that restarts within `silence` must pass the
/// same test, unless its counter fits the pause. Pure; thread-bound. No heap.
class CounterWatch {
  public:
    /// Number of advances in a row before frames are accepted: at the start and after everything
    /// that makes the sender doubtful.
    static constexpr unsigned kProof = 2;
    /// Counts without a break that are required after a break; at most the range of the counter.
    static constexpr std::uint64_t kLongestRing = 256;
    /// A second break within this many counts requires as many counts as lay between the two: it
    /// shows a rare second sender or a longer ring.
    static constexpr std::uint64_t kRemembered = 512;

    struct Limits {
        std::uint64_t values = 0;     ///< the counter goes from 0 to `values` - 1
        std::uint64_t most_step = 1;  ///< largest accepted step: above 1 if frames may be lost
        Duration silence{};           ///< after a longer pause the counter proves nothing
        unsigned proof = kProof;      ///< advances in a row before frames are accepted; 0: none
    };

    enum class Verdict : std::uint8_t {
        good,
        unconfirmed,  ///< the counter advanced correctly, but the proof is incomplete
        repeated,     ///< the same counter with the same content
        conflict,     ///< the same counter with other content
        jump,         ///< step above `most_step`, too soon for its step, or a value that the
                      ///< counter cannot have
    };

    explicit CounterWatch(const Limits& limits) : limits_(limits) {}

    /// Takes the counter of a frame or snapshot that arrived at `received`. `same_content`: its
    /// content equals that of the one before.
    Verdict take(std::uint64_t count, bool same_content, Instant received);
    /// Another sign makes the sender doubtful: starts the proof again.
    void restart_proof() { proof_ = 0; }
    /// Another sign shows a second sender or a ring: requires the long test.
    void require_long_proof();

  private:
    Verdict begin();
    Verdict advance(std::uint64_t step);
    bool time_allows(std::uint64_t step, Duration elapsed) const;
    void learn_pace(std::uint64_t step, Duration elapsed);

    Limits limits_;
    /// The latest counter value, unless it was one that the counter cannot have.
    std::optional<std::uint64_t> count_;
    Instant received_{};
    unsigned proof_ = 0;
    std::uint64_t due_ = 0;            ///< counts still required after a break
    std::uint64_t run_ = kRemembered;  ///< counts since the last break, limited
    Duration pace_{};                  ///< estimated time of one count; zero: unknown
    Duration spare_{};                 ///< by how much the latest frame came later than the pace
};

}  // namespace tribus
