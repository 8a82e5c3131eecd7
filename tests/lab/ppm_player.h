#pragma once

#include <cstdint>
#include <vector>

#include "tests/lab/gpio_bank.h"
#include "transports/links/unique_fd.h"

namespace tribus::test {

/// A distance of two edges that cannot be known better than by the clock before and after each.
struct PlayedPulse {
    double least_us = 0;
    double most_us = 0;
};
using PlayedFrame = std::vector<PlayedPulse>;

/// Plays pulses on an input line of a simulated chip: up at each edge, down 300 us later. While it
/// plays, its thread goes before all others that are not real time.
class PpmPlayer {
  public:
    PpmPlayer(const GpioBank& bank, unsigned line);

    /// Plays one frame, its channels in microseconds, and returns what it played. Before the first
    /// edge it waits until `gap_us` have passed since the last edge of the frame before.
    PlayedFrame play(const std::vector<double>& channels_us, double gap_us = 6000);
    /// One pulse more, by which the last channel ends, is part of each frame. This plays single
    /// edges instead: nothing but pulses, `count` of them, `distance_us` apart.
    void play_noise(int count, double distance_us);

  private:
    struct Moment {
        std::uint64_t before_ns = 0;
        std::uint64_t after_ns = 0;
    };
    Moment pulse_at(std::uint64_t at_ns);

    UniqueFd pull_;
    std::uint64_t latest_ns_ = 0;
};

}  // namespace tribus::test
