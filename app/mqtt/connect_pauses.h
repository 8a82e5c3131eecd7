#pragma once

#include <chrono>
#include <cstdint>
#include <random>

#include "core/time.h"

namespace tribus::mqtt {

/// Pauses between attempts to connect. Each has a limit twice that of the one before, and its
/// length is left to chance: many boards that lost one broker at the same moment must not come back
/// at the same moment. Pure.
class ConnectPauses {
  public:
    /// `seed`: another one for each board.
    explicit ConnectPauses(std::uint32_t seed) : random_(seed) {}

    /// The next one, from half of its limit to the whole.
    Duration next();
    /// The connection was there: the next pause is a first one.
    void connected() { limit_ = kFirstLimit; }

    static constexpr Duration kFirstLimit = std::chrono::seconds(2);
    static constexpr Duration kLastLimit = std::chrono::seconds(30);

  private:
    std::minstd_rand random_;
    Duration limit_ = kFirstLimit;
};

}  // namespace tribus::mqtt
