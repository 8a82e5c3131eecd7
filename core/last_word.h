#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "core/rate_limit.h"
#include "core/time.h"

namespace tribus {

/// What was said last of a thing that changes, so that the last word on it stays true though lines
/// are limited: a change that may not be said yet is said once it may, unless it was undone by
/// then. Pure; thread-bound.
template <class State>
class LastWord {
  public:
    explicit LastWord(State first) : seen_(first), said_(std::move(first)) {}

    /// The number of changes that were swallowed before, if `state`, which is so at `now`, is to be
    /// said. Ask again at each look: it may have to wait for `limit`.
    std::optional<std::uint64_t> look(const State& state, RateLimit& limit, Instant now) {
        if (state != seen_) {
            seen_ = state;
            ++changes_;
        }
        if (state == said_ || !limit.may_pass(now)) {
            return std::nullopt;
        }
        said_ = state;
        return *limit.pass(now) + std::exchange(changes_, 0) - 1;
    }
    /// `state` needs no word.
    void take_as_known(const State& state) {
        seen_ = state;
        said_ = state;
    }

    const State& seen() const { return seen_; }
    const State& said() const { return said_; }

  private:
    State seen_;
    State said_;
    std::uint64_t changes_ = 0;  ///< since the last word
};

}  // namespace tribus
