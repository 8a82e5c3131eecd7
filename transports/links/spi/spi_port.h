#pragma once

#include <cerrno>
#include <cstdint>
#include <string>

#include <tl/expected.hpp>

#include "core/time.h"
#include "transports/links/spi/spi_clock.h"
#include "transports/links/unique_fd.h"

namespace tribus {

enum class SpiUse : std::uint8_t {
    draws,    ///< with the data line out of the port (MOSI), which must rest low
    listens,  ///< with the data line into the port (MISO)
};

struct SpiPort {
    UniqueFd file;
    std::uint32_t hz = 0;  ///< the rate that it was asked for
};

/// Opens an SPI port, and sends zeros to measure it, for up to a second, until a byte lasts
/// `byte_time` (spi_clock.h). The error begins with the device and says what to do. Thread-safe.
tl::expected<SpiPort, std::string> open_spi_port(const std::string& device, SpiUse use,
                                                 Duration byte_time, Instant (*now)());

/// Sends zeros through it, for `measure_spi_byte` and its like. Thread-bound.
SpiTransfer zeros_through(const UniqueFd& file, Instant (*now)());

/// Why the port cannot be used so, as far as that is seen without sending; empty if it can.
std::string why_no_spi_port(const std::string& device, SpiUse use);

/// Whether an error of a transfer says that the port is gone.
constexpr bool is_spi_port_gone(int error) {
    return error == ENODEV || error == ENXIO || error == ESHUTDOWN;
}

}  // namespace tribus
