#pragma once

#include <linux/spi/spidev.h>
#include <sys/ioctl.h>

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "tests/support/device_stand_in.h"

namespace tribus::test {

/// The device node of an SPI port (linux/spi/spidev.h, drivers/spi/spidev.c): requests that set
/// something return 0. Subclasses say what a transfer does; `bytes_ns` is how long it takes.
class SpiPortStandIn : public DeviceStandIn {
  public:
    using DeviceStandIn::DeviceStandIn;

    Answer control(unsigned long request, void* argument) override {
        if (request == SPI_IOC_WR_MAX_SPEED_HZ) {
            hz = *static_cast<std::uint32_t*>(argument);
        }
        return 0;
    }
    std::int64_t bytes_ns(std::size_t bytes) const {
        return static_cast<std::int64_t>(static_cast<double>(bytes) * 1e9 * clocks_a_byte / hz *
                                         slowness);
    }
    /// What a transfer takes beside its bytes.
    static constexpr std::int64_t kCallNs = 40'000;

    std::atomic<std::uint32_t> hz = 0;  ///< the rate that it was asked for
    std::atomic<double> clocks_a_byte = 8;
    std::atomic<double> slowness = 1;  ///< of its clock
};

}  // namespace tribus::test
