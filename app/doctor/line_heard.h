#pragma once

#include <cstdint>
#include <vector>

#include "core/line_settings.h"
#include "core/time.h"
#include "transports/links/recording.h"

namespace tribus::doctor {

/// What a port heard while it had these settings.
struct Heard {
    LineSettings line;
    Duration listened{};
    /// One for each read, with the time since the listening began at which its bytes were there.
    /// The value of a damaged byte is the one that the port told.
    std::vector<Burst> bursts;
};

/// Of i.Bus; every port has it.
inline constexpr std::uint32_t kUsualBaud = 115'200;

/// As `tribus run` sets ports for i.Bus and the sensor bus, SBUS, and fast SBUS.
inline constexpr LineSettings kIbusLine{.baud = kUsualBaud};
inline constexpr LineSettings kSbusLine{.baud = 100'000, .parity = Parity::even, .stop_bits = 2};
inline constexpr LineSettings kFastSbusLine{
    .baud = 200'000, .parity = Parity::even, .stop_bits = 2};

}  // namespace tribus::doctor
