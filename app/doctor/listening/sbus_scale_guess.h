#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "transports/codecs/sbus/scale.h"

namespace tribus::doctor {

/// The scale that the raw values suggest. It is never certain: two scales differ only by a few
/// steps for the same stick.
struct ScaleGuess {
    std::string_view name;  ///< empty: cannot be determined
    std::string reason;     ///< for people; set in both cases
};

/// Collects the centres and ends of a sender's channels.
class ScaleWatch {
  public:
    /// Takes the raw values of one frame.
    void take(std::span<const std::uint16_t> raw);
    /// The scale that fits the values so far.
    ScaleGuess guess() const;

  private:
    struct Seen {
        std::uint16_t least = kSbusRawMost;
        std::uint16_t most = 0;
        std::uint16_t latest = 0;
    };
    std::string implausible_with(const SbusScale& scale) const;

    std::array<Seen, kSbusChannels> seen_{};
    bool any_ = false;
};

}  // namespace tribus::doctor
