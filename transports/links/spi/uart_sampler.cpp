#include "transports/links/spi/uart_sampler.h"

#include <algorithm>
#include <bit>

namespace tribus {
namespace {

constexpr std::size_t kBitsOfData = 8;

/// Samples of a line, as it is without an inverter: at rest it is a mark.
class Samples {
  public:
    Samples(std::span<const std::uint8_t> samples, bool inverted)
        : samples_(samples), flip_(inverted ? 0xFF : 0x00) {}

    std::size_t count() const { return samples_.size() * kSamplesPerBit; }
    bool mark(std::size_t sample) const {
        return (byte(sample / kSamplesPerBit) >> (7 - sample % kSamplesPerBit) & 1U) != 0;
    }
    /// The first sample from `sample` on that is a mark, or is none, as `wanted`; else `count`.
    std::size_t find(bool wanted, std::size_t sample) const {
        const std::uint8_t passed = wanted ? 0x00 : 0xFF;
        while (sample < count() && mark(sample) != wanted) {
            const std::size_t place = sample / kSamplesPerBit;
            const bool skips = sample % kSamplesPerBit == 0 && byte(place) == passed;
            sample += skips ? kSamplesPerBit : 1;
        }
        return std::min(sample, count());
    }
    /// The level of a bit that begins at that sample.
    bool bit(std::size_t begin) const {
        constexpr std::size_t kFirst = 1;
        constexpr std::size_t kVotes = 5;
        std::size_t marks = 0;
        for (std::size_t vote = 0; vote < kVotes; ++vote) {
            marks += mark(begin + kFirst + vote) ? 1U : 0U;
        }
        return marks > kVotes / 2;
    }

  private:
    std::uint8_t byte(std::size_t place) const {
        return static_cast<std::uint8_t>(samples_[place] ^ flip_);
    }

    std::span<const std::uint8_t> samples_;
    std::uint8_t flip_;
};

SampledByte byte_at(const Samples& samples, std::size_t begin, const LineSettings& line) {
    SampledByte found{.begin = begin};
    std::size_t at = begin;
    for (std::size_t i = 0; i < kBitsOfData; ++i) {
        at += kSamplesPerBit;
        found.value = static_cast<std::uint8_t>(found.value | (samples.bit(at) ? 1U : 0U) << i);
    }
    if (line.parity == Parity::even) {
        at += kSamplesPerBit;
        found.damaged = samples.bit(at) != (std::popcount(found.value) % 2 != 0);
    }
    found.damaged = found.damaged || !samples.bit(at + kSamplesPerBit);
    return found;
}

}  // namespace

void sample_uart(std::span<const std::uint8_t> raw, const LineSettings& line, SampledBlock& block) {
    const Samples samples(raw, line.inverted_wire);
    const std::size_t bits = line.bits_per_byte();
    // Start bit, data and parity; the first stop bit is judged, the others may be short.
    const std::size_t to_stop = (bits - line.stop_bits) * kSamplesPerBit;
    block.count = 0;
    block.cut = false;
    std::size_t at = 0;
    for (std::size_t rest = 0; rest < bits * kSamplesPerBit;) {
        at = samples.find(true, at);
        const std::size_t end = samples.find(false, at);
        rest = end - at;
        at = end;
        if (at == samples.count()) {
            block.cut = rest < bits * kSamplesPerBit;
            return;
        }
    }
    std::size_t free_from = 0;
    while ((at = samples.find(false, at)) < samples.count()) {
        if (at + to_stop + kSamplesPerBit > samples.count()) {
            block.cut = true;
            return;
        }
        if (samples.bit(at)) {
            ++at;  // shorter than half of a bit: none
            continue;
        }
        const SampledByte& found = block.bytes[block.count++] = byte_at(samples, at, line);
        const std::size_t stop = at + to_stop;
        // A line that is not back at rest begins no further byte.
        at = found.damaged ? samples.find(true, stop) : stop + kSamplesPerBit / 2;
        free_from = at;
    }
    block.cut = free_from + bits * kSamplesPerBit > samples.count();
}

}  // namespace tribus
