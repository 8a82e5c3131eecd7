#pragma once

#include <fcntl.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/lab/recorded_receiver.h"
#include "tests/loopback/loopback.h"
#include "transports/links/unique_fd.h"

/// The built program on the kernel's driver for the PCA9685, whose chip is a bank of registers in
/// memory (i2c-stub): what the driver wrote there is what would come out of the chip.
namespace tribus::test::pca9685 {

inline constexpr int kAddress = 0x40;

/// The registers of the chip, read past the driver.
class Registers {
  public:
    explicit Registers(const std::string& adapter)
        : fd_(::open(("/dev/" + adapter).c_str(), O_RDWR | O_CLOEXEC)) {
        EXPECT_TRUE(fd_.valid()) << adapter;
        EXPECT_EQ(::ioctl(fd_.get(), I2C_SLAVE_FORCE, kAddress), 0);
    }
    int at(int number) const {
        i2c_smbus_data data{};
        i2c_smbus_ioctl_data request{.read_write = I2C_SMBUS_READ,
                                     .command = static_cast<std::uint8_t>(number),
                                     .size = I2C_SMBUS_BYTE_DATA,
                                     .data = &data};
        EXPECT_GE(::ioctl(fd_.get(), I2C_SMBUS, &request), 0) << number;
        return data.byte;
    }
    // Data sheet of the PCA9685, 7.3.3 and 7.3.5: four registers an output, on and off, each a
    // count from 0 to 4095; bit 4 of the high byte of "off" switches the output off.
    bool is_off(int output) const { return (at(9 + 4 * output) & 0x10) != 0; }
    int count(int output) const {
        const int on = at(6 + 4 * output) | (at(7 + 4 * output) & 0x0F) << 8;
        const int off = at(8 + 4 * output) | (at(9 + 4 * output) & 0x0F) << 8;
        return (off - on + 4096) % 4096;
    }
    int prescale() const { return at(0xFE); }
    // 7.3.1: the oscillator stands still.
    bool sleeps() const { return (at(0) & 0x10) != 0; }

  private:
    UniqueFd fd_;
};

class LabPwm : public Loopback {
  protected:
    LabPwm() {
        require_guest();
        shell("modprobe i2c-dev; modprobe i2c-stub chip_addr=0x40; modprobe pwm-pca9685");
        for (const auto& entry : std::filesystem::directory_iterator("/sys/bus/i2c/devices")) {
            if (read_file(entry.path() / "name").starts_with("SMBus stub driver")) {
                adapter_ = entry.path().filename();
            }
        }
        write_kernel_file("/sys/bus/i2c/devices/" + adapter_ + "/new_device", "pca9685 0x40");
    }
    ~LabPwm() override {
        write_kernel_file("/sys/bus/i2c/devices/" + adapter_ + "/delete_device", "0x40");
        shell("rmmod pwm-pca9685; rmmod i2c-stub");
    }
    std::string config(const std::string& input = "", const std::string& output = "") {
        return write_config("[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\n" +
                            input + "[output.legs]\nprotocol = \"pwm\"\nchip = \"pca9685-pwm\"\n" +
                            "outputs = { 1 = 0, 2 = 1, 3 = 4, 4 = 15 }\n" + output +
                            "[pipeline.main]\nfrom = \"receiver\"\nto = \"legs\"\n"
                            "[pipeline.main.failsafe]\nhold = \"0s\"\nrecover = \"0s\"\n");
    }
    const std::string& adapter() const { return adapter_; }

  private:
    std::string adapter_;
};

inline constexpr std::array kOutputs{0, 1, 4, 15};

/// The channels that the chip gets.
inline Sticks sent(const Sticks& sticks) {
    return {sticks.begin(), sticks.begin() + kOutputs.size()};
}

/// Linux 6.17 and later have it.
inline bool has_device() {
    return std::filesystem::exists("/dev/pwmchip0");
}

/// The count for a pulse of a period of 20 ms. The driver of before rounds up; the one that came
/// with the device rounds down, to 122 * 40 ns.
inline int count_of_pulse(int microseconds) {
    return has_device() ? 1000 * microseconds / 4880 : (4096 * microseconds + 19999) / 20000;
}

inline bool shows(const Registers& chip, const Sticks& sticks) {
    for (std::size_t i = 0; i < kOutputs.size(); ++i) {
        if (chip.is_off(kOutputs[i]) || chip.count(kOutputs[i]) != count_of_pulse(sticks[i])) {
            return false;
        }
    }
    return true;
}

inline bool all_off(const Registers& chip) {
    return std::ranges::all_of(kOutputs, [&](int output) { return chip.is_off(output); });
}

}  // namespace tribus::test::pca9685
