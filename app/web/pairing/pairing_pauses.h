#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "core/time.h"

namespace tribus::web {

/// How long who typed wrong codes has to wait. Each address has a pause of its own, so nobody keeps
/// others from pairing. Pure; thread-bound.
class PairingPauses {
  public:
    static constexpr Duration kFirst = std::chrono::seconds(1);
    static constexpr Duration kLongest = std::chrono::seconds(32);
    static constexpr Duration kForgotten = std::chrono::minutes(10);
    static constexpr std::size_t kMostAddresses = 256;

    /// How long codes of that address do not count at `now`. Zero: they do.
    Duration left(const std::string& address, Instant now) const;
    /// After a wrong code at `now`: each pause is twice as long as the one before. Returns it.
    Duration wrong(const std::string& address, Instant now);
    /// After a right code.
    void right(const std::string& address) { pauses_.erase(address); }

  private:
    struct Pause {
        Duration length{};
        Instant end{};
    };
    std::map<std::string, Pause> pauses_;
};

}  // namespace tribus::web
