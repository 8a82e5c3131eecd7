#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "core/time.h"
#include "transports/links/pwm/pwm_device.h"

namespace tribus {

/// The folders of PWM chips and of their devices, from the root of the files.
inline constexpr const char* kPwmFolder = "sys/class/pwm";
inline constexpr const char* kPwmDeviceFolder = "dev";

/// A PWM chip as the kernel shows it: "pwmchip0", with the name of its driver.
struct PwmChipFacts {
    std::filesystem::path folder;
    std::string name;
    std::string driver;  ///< "pca9685-pwm"; empty if unknown
    std::size_t outputs = 0;
    std::filesystem::path device{};  ///< empty if it has none
};

/// The PWM chips of this machine, by their numbers. May block.
std::vector<PwmChipFacts> find_pwm_chips(const std::filesystem::path& root = "/");

/// The chip with that name, or the only one with that driver. The error says what is allowed. May
/// block.
tl::expected<PwmChipFacts, std::string> find_pwm_chip(const std::string& name,
                                                      const std::filesystem::path& root = "/");

/// Whether no chip, or more than one, has that name or driver now; false if that is not known. May
/// block.
bool is_pwm_chip_missing(const std::string& name, const std::filesystem::path& root = "/");

/// The outputs of a chip, by its device if there is one and this user may open it, or else by its
/// files. Each call may take the time of some transfers on the chip's bus. Thread-bound.
class PwmOutputs {
  public:
    static constexpr std::size_t kMost = 64;

    PwmOutputs(PwmChipFacts chip, Duration period);
    PwmOutputs(const PwmOutputs&) = delete;
    PwmOutputs& operator=(const PwmOutputs&) = delete;
    /// Switches off and gives back what this object took.
    ~PwmOutputs();

    /// Sends pulses of that length each period; 0: switches the output off. Writes only what
    /// changed. Returns an empty text, or which file the kernel refused and why.
    std::string set(std::size_t output, std::uint32_t nanoseconds);
    /// Whether the kernel does not show the chip any more, or shows it anew.
    bool gone() const;

  private:
    enum class State : std::uint8_t { unused, taken, on };
    bool by_device(std::size_t output) const { return by_device_[output]; }
    std::string take(std::size_t output);
    std::string take_by_files(std::size_t output);
    std::string set_by_files(std::size_t output, std::uint32_t nanoseconds);
    void give_back(std::size_t output);
    std::string write(std::size_t output, const char* file, const std::string& text) const;

    PwmChipFacts chip_;
    Duration period_;
    PwmDevice device_;
    std::array<bool, kMost> by_device_{};
    std::array<State, kMost> states_{};
    std::array<std::optional<std::uint32_t>, kMost> pulses_{};
};

/// An output that a program has taken.
struct PwmOutputFacts {
    bool on = false;
    Duration pulse{};
    Duration period{};
};

/// The state of an output; nothing if no program has taken it by its files. Who has taken it by the
/// chip's device cannot be seen. May block.
std::optional<PwmOutputFacts> look_at(const PwmChipFacts& chip, std::size_t output);

/// Switches an output off that a program had and left on. One that a program still has by the
/// chip's device is refused. Returns an empty text, or what the kernel refused.
std::string switch_off(const PwmChipFacts& chip, std::size_t output);

}  // namespace tribus
