#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// The character device of a PWM chip, `/dev/pwmchipN`: Linux 6.17 and later have it for the
/// drivers that can change period and pulse in one step. What a program has requested is given back
/// when it ends, however it ends; some drivers then switch the output off. Thread-bound. Each call
/// may take the time of a transfer on the chip's bus. Texts are empty, or say what the kernel
/// refused and why.
///
/// Source: Linux, include/uapi/linux/pwm.h and drivers/pwm/core.c.
class PwmDevice {
  public:
    /// Without a device, or without the right to open it, nothing of it is used.
    explicit PwmDevice(const std::filesystem::path& path);

    bool is_open() const { return device_.valid(); }
    /// Whether the kernel has removed the device that is open.
    bool gone() const;
    /// Takes an output, which nobody else may have, and switches it off. The first one of a chip
    /// whose outputs share a period sets it.
    std::string take(std::size_t output, Duration period) const;
    /// Some drivers switch the output off.
    void give_back(std::size_t output) const;
    /// The next period has this length and this pulse, 1 ns or longer. The chip rounds both down to
    /// what it can. An error if it then has another period.
    std::string set(std::size_t output, Duration period, std::uint32_t pulse_nanoseconds) const;
    std::string switch_off(std::size_t output) const;

  private:
    /// The refusal of the kernel, from errno.
    std::string refused(std::size_t output) const;

    std::filesystem::path path_;
    UniqueFd device_;
};

}  // namespace tribus
