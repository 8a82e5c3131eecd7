#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/fuzz.h"
#include "transports/links/spi/sampling_plan.h"
#include "transports/links/spi/uart_sampler.h"

namespace tribus::fuzz::spi_sampler_target {

/// Any bits, as an SPI port may sample them in blocks: the bytes that are found stand in their
/// order and do not overlap, and the plan that follows them always has a block that the port takes.
FUZZ_TARGET(spi_sampler) {
    constexpr Duration kBit = std::chrono::microseconds(10);
    constexpr Duration kLongest = kMostWaveformBytes * kBit;
    Input input({data, size});
    const std::uint8_t kind = input.byte();
    const LineSettings line{.baud = 100'000,
                            .parity = (kind & 1U) != 0 ? Parity::even : Parity::none,
                            .stop_bits = static_cast<std::uint8_t>(1 + (kind >> 1U & 1U)),
                            .inverted_wire = (kind & 4U) != 0};
    const std::size_t least = (line.bits_per_byte() - line.stop_bits) * kSamplesPerBit;
    SamplingPlan plan(kLongest);
    SampledBlock block;
    Instant now{std::chrono::seconds(1)};
    while (!input.empty()) {
        const Duration length = plan.next(now);
        require(length > Duration::zero() && length <= kLongest, "a block that the port takes");
        const auto samples = input.take(static_cast<std::size_t>(length / kBit));
        sample_uart(samples, line, block);
        for (std::size_t i = 0; i < block.count; ++i) {
            const SampledByte& byte = block.bytes[i];
            require(byte.begin + least <= samples.size() * kSamplesPerBit,
                    "a byte is in the block");
            require(i == 0 || byte.begin >= block.bytes[i - 1].begin + least,
                    "bytes do not overlap");
            const Instant begin = now + static_cast<std::int64_t>(byte.begin) * kBit / 8;
            plan.found({.begin = begin, .end = begin + kBit * 12, .cut = byte.damaged});
        }
        plan.ended(now + length);
        now += length;
    }
    return 0;
}

}  // namespace tribus::fuzz::spi_sampler_target
