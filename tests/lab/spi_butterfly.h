#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/shell.h"

namespace tribus::test {

/// The SPI port that the driver spi-butterfly makes of the emulator's parallel port, as long as
/// this object is there.
class SpiButterfly {
  public:
    SpiButterfly() {
        shell("modprobe parport_pc io=0x378; modprobe spidev; modprobe spi-butterfly");
        for (const auto& entry : std::filesystem::directory_iterator("/sys/bus/spi/devices")) {
            std::ofstream(entry.path() / "driver_override") << "spidev" << std::flush;
            std::ofstream("/sys/bus/spi/drivers/spidev/bind") << entry.path().filename().string();
            device_ = "/dev/spidev" + entry.path().filename().string().substr(3);
        }
        EXPECT_TRUE(std::filesystem::exists(device_)) << device_;
    }
    SpiButterfly(const SpiButterfly&) = delete;
    SpiButterfly& operator=(const SpiButterfly&) = delete;
    ~SpiButterfly() { shell("rmmod spi-butterfly; rmmod spidev; rmmod parport_pc"); }

    const std::string& device() const { return device_; }
    /// The bits that its data line had since the last call, of which the trace of the parallel port
    /// tells: bit 0 of its data register is the clock, bit 7 the data
    /// (drivers/spi/spi-butterfly.c). The trace begins with the guest.
    std::vector<bool> sent_bits() {
        std::vector<bool> bits;
        auto end = trace_.tellg();
        for (std::string line; std::getline(trace_, line) && !trace_.eof(); end = trace_.tellg()) {
            if (line.find("parallel_ioport_write write [SW] addr 0x00 ") == std::string::npos) {
                continue;
            }
            const auto data = std::stoul(line.substr(line.rfind(' ') + 1), nullptr, 16);
            const bool clock = (data & 1) != 0;
            if (clock && !std::exchange(clock_, clock)) {
                bits.push_back((data & 0x80) != 0);
            }
            clock_ = clock;
        }
        // The last line may not be whole yet.
        trace_.clear();
        trace_.seekg(end);
        return bits;
    }

  private:
    std::string device_;
    // The path in run_guest.
    std::ifstream trace_{"/lab/trace"};
    bool clock_ = false;
};

}  // namespace tribus::test
