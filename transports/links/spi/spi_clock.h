#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "core/time.h"

/// How long an SPI port needs for a byte. A controller takes 8 clocks for it, or 9 (a Raspberry Pi
/// without DMA), or something between, and its clock is that of another one divided by a whole
/// number; so the time is measured (docs/boards/spi.md). Pure.
namespace tribus {

/// Sends so many zeros at that rate. Returns how long it took, or nothing if the port refuses.
using SpiTransfer = std::function<std::optional<Duration>(std::uint32_t hz, std::size_t bytes)>;

/// How long a byte takes at that rate. Nothing if the port refuses.
std::optional<Duration> measure_spi_byte(std::uint32_t hz, const SpiTransfer& transfer);

/// How far the time of a byte may be from the one that is wanted.
inline constexpr double kSpiTolerance = 0.005;

/// Measures rates until a byte takes `wanted`, and returns the one to ask for, in Hz. The error has
/// the figures.
tl::expected<std::uint32_t, std::string> find_spi_rate(Duration wanted,
                                                       const SpiTransfer& transfer);

}  // namespace tribus
