#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/doctor/facts/finding.h"
#include "transports/links/gpio/gpio_search.h"

namespace tribus::doctor {

/// A GPIO chip, and those of its lines that were asked for.
struct GpioFacts {
    GpioChip chip{};
    std::vector<unsigned> asked{};  ///< offsets
};

/// Whether the name of a device is one of a GPIO chip or line, there or not: "gpiochip0",
/// "gpiochip0:17", "GPIO17", or any name that a line of `chips` has. Pure.
bool names_gpio(const std::string& device, std::span<const GpioChip> chips);

/// The chip or line that the user named, if it is there. `chip_path`: that of the name, with
/// symbolic links resolved. Pure.
std::optional<GpioFacts> look_at_gpio(const std::string& device, const std::string& chip_path,
                                      std::span<const GpioChip> chips);

/// Says why a configuration cannot use the chip or line that the user named. Pure.
std::vector<Finding> judge_gpio(const std::string& device, const std::string& chip_path,
                                std::span<const GpioChip> chips);

/// Says why a configuration cannot use a chip that nobody asked for. Pure.
std::vector<Finding> judge_gpio_chip(const GpioChip& chip);

/// "GPIO chip with 58 lines, 3 of them in use".
std::string describe(const GpioFacts& facts);

/// Lines for a configuration, if one free line was asked for.
std::vector<std::string> configuration_lines(const GpioFacts& facts);

/// The path of the chip in the name of a device, or an empty text. May block.
std::string gpio_chip_path(const std::string& device);

}  // namespace tribus::doctor
