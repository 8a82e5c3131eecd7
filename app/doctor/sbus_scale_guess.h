#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "transports/codecs/sbus_scale.h"

namespace tribus::doctor {

/// Which scale the raw values of a sender speak for, and how much. There is no proof: two scales
/// differ by a few steps of the same stick.
struct ScaleGuess {
    std::string_view name;  ///< empty: it cannot be known from what was heard
    std::string reason;     ///< for a person, also where it cannot be known
};

/// Collects where the channels of a sender rest and end.
class ScaleWatch {
  public:
    void take(std::span<const std::uint16_t> raw);
    ScaleGuess guess() const;

  private:
    struct Seen {
        std::uint16_t least = kSbusRawMost;
        std::uint16_t most = 0;
        std::uint16_t latest = 0;
    };
    std::array<Seen, kSbusChannels> seen_{};
    bool any_ = false;
};

}  // namespace tribus::doctor
