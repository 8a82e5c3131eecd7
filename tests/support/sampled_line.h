#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

namespace tribus::test {

/// An inverted serial line with a sender of SBUS on it, as an SPI port samples it. Times in us.
class SampledLine {
  public:
    /// `rate_error`: how much faster than it should the sender's clock is.
    explicit SampledLine(double rate_error = 0) : bit_us_(10 / (1 + rate_error)) {}

    /// Start bit high, eight data bits, parity and two stop bits, all inverted. Times ascend.
    void send(double begin_us, const std::vector<std::uint8_t>& bytes) {
        Burst burst{begin_us, {}};
        for (const std::uint8_t byte : bytes) {
            burst.levels.push_back(true);
            bool parity = false;
            for (unsigned bit = 0; bit < 8; ++bit) {
                const bool one = (byte >> bit & 1U) != 0;
                parity = parity != one;
                burst.levels.push_back(!one);
            }
            burst.levels.push_back(!parity);
            burst.levels.push_back(false);
            burst.levels.push_back(false);
        }
        bursts_.push_back(std::move(burst));
    }
    double length_us(std::size_t bytes) const { return static_cast<double>(bytes) * 12 * bit_us_; }
    /// Two bursts at once are as of a wired or.
    bool level(double at_us) const {
        auto burst = std::ranges::upper_bound(bursts_, at_us, {}, &Burst::begin_us);
        for (int looked = 0; looked < 2 && burst != bursts_.begin(); ++looked) {
            --burst;
            const double bit = (at_us - burst->begin_us) / bit_us_;
            if (bit < static_cast<double>(burst->levels.size()) &&
                burst->levels[static_cast<std::size_t>(bit)]) {
                return true;
            }
        }
        return false;
    }
    /// A controller that needs so many clocks for a byte; a byte takes `byte_us`.
    std::vector<std::uint8_t> sample(double begin_us, std::size_t bytes, double clocks_a_byte = 8,
                                     double byte_us = 10) {
        while (!bursts_.empty() && bursts_.front().begin_us + 100'000 < begin_us) {
            bursts_.pop_front();
        }
        std::vector<std::uint8_t> samples(bytes);
        for (std::size_t i = 0; i < bytes; ++i) {
            for (unsigned bit = 0; bit < 8; ++bit) {
                const double at =
                    begin_us + byte_us * (static_cast<double>(i) + bit / clocks_a_byte);
                samples[i] = static_cast<std::uint8_t>(samples[i] << 1U | (level(at) ? 1U : 0U));
            }
        }
        return samples;
    }

  private:
    struct Burst {
        double begin_us;
        std::vector<bool> levels;
    };

    double bit_us_;
    std::deque<Burst> bursts_;
};

}  // namespace tribus::test
