#pragma once

#include <cstddef>
#include <optional>

#include "core/time.h"

namespace tribus {

/// Bytes without a pause between them.
struct SampledBurst {
    Instant begin{};
    Instant end{};
    /// The block ended within it, or directly behind it: it may be longer.
    bool cut = false;
};

/// A port takes samples in blocks that follow each other. What was received is not known before a
/// block ends, and between two blocks the port takes none, so a burst that goes on then is lost.
/// Finds out when a sender's bursts come, and ends each block shortly behind one: as soon as
/// possible, and as late as the sender's jitter demands. It listens to the pauses too: a sender
/// that is twice as fast as it was would look the same around the expected bursts alone. Pure;
/// thread-bound.
class SamplingPlan {
  public:
    /// `longest`: the longest block that the port takes.
    explicit SamplingPlan(Duration longest);

    /// How long the block must be that begins now.
    Duration next(Instant now) const;
    /// A burst of undamaged bytes in the block that has been taken, in their order.
    void found(const SampledBurst& burst);
    /// All bursts of the block have been told, which ended then.
    void ended(Instant end);
    /// For how long no burst is expected from now on. Without a rhythm: the longest time.
    Duration pause(Instant now) const;
    /// Whether it knows the rhythm of a sender.
    bool follows() const { return period_ > Duration::zero(); }

  private:
    void begin_rhythm(Instant begin);
    void keep_rhythm(Instant begin, Duration error);
    void lose_rhythm();
    Duration late_by() const;
    Instant next_burst(Instant now) const;

    Duration longest_;
    std::optional<Instant> latest_;  ///< begin of the latest burst, of a rhythm its mean
    Duration period_{};              ///< zero: not known
    Duration length_{};              ///< of a burst
    Duration jitter_{};              ///< decays while bursts come as expected
    bool came_ = false;              ///< a burst told the rhythm in this block
    bool whole_ = false;             ///< it has a whole burst
    int deaf_ = 0;                   ///< blocks in a row without one
    int missed_ = 0;                 ///< expected ones in a row that did not come
};

}  // namespace tribus
