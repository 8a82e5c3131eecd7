#include "transports/links/spi/uart_waveform.h"

#include <algorithm>
#include <bit>
#include <cstddef>

namespace tribus {
namespace {

/// Bits at rest before the first byte and behind the last one: what a controller does with its data
/// line at the ends of a transfer is no bit of the frame.
constexpr std::size_t kRest = 2;

}  // namespace

bool draw_uart(std::span<const std::uint8_t> bytes, const LineSettings& line,
               SpiWaveform& waveform) {
    const std::size_t needed = bytes.size() * line.bits_per_byte() + 2 * kRest;
    waveform.bytes = 0;
    if (bytes.empty() || needed > kMostWaveformBytes) {
        return false;
    }
    const auto add = [&](bool mark) {
        waveform.bits[waveform.bytes++] = mark != line.inverted_wire ? 0xFF : 0x00;
    };
    const auto rest = [&](std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            add(true);
        }
    };
    rest(kRest);
    for (const std::uint8_t byte : bytes) {
        constexpr unsigned kDataBits = 8;
        add(false);
        for (unsigned bit = 0; bit < kDataBits; ++bit) {
            add((byte >> bit & 1U) != 0);
        }
        if (line.parity == Parity::even) {
            add(std::popcount(byte) % 2 != 0);
        }
        rest(line.stop_bits);
    }
    rest(kRest);
    return true;
}

}  // namespace tribus
