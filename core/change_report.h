#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "core/rate_limit.h"
#include "core/time.h"

namespace tribus {

/// Decides which changes of a state are reported while a `RateLimit` holds. The last report always
/// becomes true: a change that must wait is reported as soon as the limit allows, unless it was
/// undone before. Pure; thread-bound.
template <class State>
class ChangeReport {
  public:
    explicit ChangeReport(State first) : seen_(first), reported_(std::move(first)) {}

    /// Call at every look, also without a change: an earlier change may be waiting. If `state` is
    /// to be reported at `now`, returns the number of changes that were not reported before it.
    std::optional<std::uint64_t> look(const State& state, RateLimit& limit, Instant now) {
        if (state != seen_) {
            seen_ = state;
            ++changes_;
        }
        if (state == reported_ || !limit.may_be_temporary(now)) {
            return std::nullopt;
        }
        reported_ = state;
        return *limit.pass(now) + std::exchange(changes_, 0) - 1;
    }
    /// Takes `state` as reported, without a report.
    void take_as_known(const State& state) {
        seen_ = state;
        reported_ = state;
    }

    const State& seen() const { return seen_; }
    const State& reported() const { return reported_; }

  private:
    State seen_;
    State reported_;
    std::uint64_t changes_ = 0;  ///< since the latest report
};

}  // namespace tribus
