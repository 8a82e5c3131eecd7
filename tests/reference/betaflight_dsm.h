#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "core/time.h"

namespace tribus::reference {

/// betaflight src/main/rx/spektrum.c, 2048 steps: a frame begins after more than 5000 us without a
/// byte and is whole with its 16th byte; further bytes are ignored until the next such gap. Nothing
/// in it is checked. Bit 15 of a word is ignored; numbers of 12 and more are no channels.
class BetaflightDsmReader {
  public:
    using Values = std::map<unsigned, unsigned>;

    /// The values of 11 bits by number, with the last byte of a frame.
    std::optional<Values> take(std::uint8_t byte, Duration at) {
        if (at - latest_ > std::chrono::microseconds(5000)) {
            count_ = 0;
        }
        latest_ = at;
        if (count_ == frame_.size()) {
            return std::nullopt;
        }
        frame_[count_++] = byte;
        return count_ == frame_.size() ? std::optional(values()) : std::nullopt;
    }

  private:
    static constexpr unsigned kChannels = 12;

    Values values() const {
        Values values;
        for (std::size_t at = 2; at < frame_.size(); at += 2) {
            const unsigned word = frame_[at] * 256U + frame_[at + 1];
            const unsigned channel = word / 2048 % 16;
            if (channel < kChannels) {
                values[channel] = word % 2048;
            }
        }
        return values;
    }

    std::array<std::uint8_t, 16> frame_{};
    std::size_t count_ = 0;
    /// A time long before the first byte.
    Duration latest_ = std::chrono::seconds(-1);
};

}  // namespace tribus::reference
