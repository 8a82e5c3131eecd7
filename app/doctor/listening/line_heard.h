#pragma once

#include <cstdint>
#include <vector>

#include "core/line_settings.h"
#include "core/time.h"
#include "transports/recordings/recording.h"

namespace tribus::doctor {

/// What a port received with these settings.
struct Heard {
    LineSettings line;
    Duration listened{};
    /// One burst for each read; its start is the time since listening began at which its bytes were
    /// there. Damaged bytes have the value that the port delivered.
    std::vector<Burst> bursts;
};

/// Rate of i.Bus; every port has it.
inline constexpr std::uint32_t kUsualBaud = 115'200;

/// Settings of `tribus run` for i.Bus and the sensor bus, for SBUS, and for fast SBUS.
inline constexpr LineSettings kIbusLine{.baud = kUsualBaud};
inline constexpr LineSettings kSbusLine{.baud = 100'000, .parity = Parity::even, .stop_bits = 2};
inline constexpr LineSettings kFastSbusLine{
    .baud = 200'000, .parity = Parity::even, .stop_bits = 2};

}  // namespace tribus::doctor
