#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "core/time.h"

namespace tribus::test {

/// A model of an SPI controller: what its data line draws, and how long that takes.
struct SpiController {
    double core_hz = 250e6;
    /// The clock is that of the core divided by a whole number, or by an even one.
    bool even_divider = true;
    /// 8, 9 (a Raspberry Pi without DMA), or something between.
    double clocks_a_byte = 8;
    /// Bytes behind which it needs some clocks more; 0: none.
    std::size_t bytes_a_burst = 0;
    double clocks_between_bursts = 0;
    double call_us = 40;
    /// The longest time by which the processor was busy, at random.
    double held_up_us = 0;
    std::mt19937 random{1};

    double clock_hz(std::uint32_t asked_hz) const {
        double divider = std::ceil(core_hz / asked_hz);
        if (even_divider && std::fmod(divider, 2) != 0) {
            ++divider;
        }
        return core_hz / divider;
    }
    /// When each byte begins, in us from the first, and where the last one ends.
    std::vector<double> times_us(std::uint32_t asked_hz, std::size_t bytes) const {
        const double clock_us = 1e6 / clock_hz(asked_hz);
        std::vector<double> times;
        double at = 0;
        for (std::size_t i = 0; i <= bytes; ++i) {
            times.push_back(at);
            const bool burst = bytes_a_burst != 0 && (i + 1) % bytes_a_burst == 0;
            at += (clocks_a_byte + (burst ? clocks_between_bursts : 0)) * clock_us;
        }
        return times;
    }
    Duration transfer_time(std::uint32_t asked_hz, std::size_t bytes) {
        std::uniform_real_distribution<double> held(0, held_up_us);
        const double us = call_us + times_us(asked_hz, bytes).back() + held(random);
        return Duration(static_cast<std::int64_t>(us * 1000));
    }
};

/// The line that it draws: the level at any time, low before and behind.
class DrawnLine {
  public:
    DrawnLine(const SpiController& controller, std::uint32_t asked_hz,
              std::span<const std::uint8_t> bytes)
        : times_(controller.times_us(asked_hz, bytes.size())),
          clock_us_(1e6 / controller.clock_hz(asked_hz)),
          bytes_(bytes.begin(), bytes.end()) {}

    double end_us() const { return times_.back(); }
    bool level(double at_us) const {
        if (at_us < 0 || at_us >= times_.back()) {
            return false;
        }
        const auto after = std::upper_bound(times_.begin(), times_.end(), at_us);
        const auto byte = static_cast<std::size_t>(after - times_.begin()) - 1;
        // Behind the eighth bit the line keeps its level.
        const double bit = std::min(std::floor((at_us - times_[byte]) / clock_us_), 7.0);
        return (bytes_[byte] >> (7 - static_cast<unsigned>(bit)) & 1U) != 0;
    }

  private:
    std::vector<double> times_;
    double clock_us_;
    std::vector<std::uint8_t> bytes_;
};

}  // namespace tribus::test
