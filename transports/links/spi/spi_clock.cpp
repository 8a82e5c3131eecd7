#include "transports/links/spi/spi_clock.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace tribus {
namespace {

constexpr double kBitsAByte = 8;
/// Both are beyond the 96 bytes from which drivers use DMA, as frames are.
constexpr std::size_t kShortBytes = 400;
constexpr std::size_t kLongBytes = 2000;
constexpr int kRepeats = 3;
constexpr int kMostRates = 8;

double in_ns(Duration duration) {
    return std::chrono::duration<double, std::nano>(duration).count();
}

/// The shortest of some transfers: others were held up. What a call takes beside its bytes is in
/// the short and the long one alike.
std::optional<double> shortest(std::uint32_t hz, std::size_t bytes, const SpiTransfer& transfer) {
    double least = std::numeric_limits<double>::max();
    for (int i = 0; i < kRepeats; ++i) {
        const auto took = transfer(hz, bytes);
        if (!took) {
            return std::nullopt;
        }
        least = std::min(least, in_ns(*took));
    }
    return least;
}

/// How long a byte takes at that rate.
std::optional<double> byte_ns_at(std::uint32_t hz, const SpiTransfer& transfer) {
    const auto brief = shortest(hz, kShortBytes, transfer);
    const auto extended = brief ? shortest(hz, kLongBytes, transfer) : std::nullopt;
    return extended
               ? std::optional((*extended - *brief) / static_cast<double>(kLongBytes - kShortBytes))
               : std::nullopt;
}

}  // namespace

std::optional<Duration> measure_spi_byte(std::uint32_t hz, const SpiTransfer& transfer) {
    const auto ns = byte_ns_at(hz, transfer);
    return ns ? std::optional(Duration(std::llround(*ns))) : std::nullopt;
}

tl::expected<std::uint32_t, std::string> find_spi_rate(Duration wanted,
                                                       const SpiTransfer& transfer) {
    constexpr double kNsPerSecond = 1e9;
    constexpr double kLeastStep = 1.005;
    const double wanted_ns = in_ns(wanted);
    double hz = kBitsAByte * kNsPerSecond / wanted_ns;
    std::set<std::string> figures;
    for (int i = 0; i < kMostRates; ++i) {
        const auto asked_hz = static_cast<std::uint32_t>(std::lround(hz));
        const auto byte_ns = byte_ns_at(asked_hz, transfer);
        if (!byte_ns) {
            return tl::unexpected(fmt::format("it refuses a transfer at {:.0f} Hz", hz));
        }
        const double ratio = *byte_ns / wanted_ns;
        if (std::abs(ratio - 1) <= kSpiTolerance) {
            return asked_hz;
        }
        constexpr double kLeast = 0.1;
        if (!std::isfinite(ratio) || ratio < kLeast || ratio > 1 / kLeast) {
            return tl::unexpected(fmt::format(
                "a byte at {:.0f} Hz takes {:.2f} us, so it is no SPI port that sends by a clock",
                hz, *byte_ns / 1000));
        }
        figures.insert(fmt::format("{:.2f} us at {:.0f} Hz", *byte_ns / 1000, hz));
        // The clock is divided by whole numbers: a step that is too small asks for the same again.
        hz *= ratio > 1 ? std::max(ratio, kLeastStep) : std::min(ratio, 1 / kLeastStep);
    }
    return tl::unexpected(
        fmt::format("no rate fits: a byte must take {:.2f} us, within {:.1f} %, and takes {}",
                    wanted_ns / 1000, kSpiTolerance * 100, fmt::join(figures, ", ")));
}

}  // namespace tribus
