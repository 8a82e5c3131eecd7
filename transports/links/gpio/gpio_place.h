#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>

/// A GPIO line as users write it. Pure and reentrant.
namespace tribus {

struct GpioPlace {
    /// "gpiochip0" or a path; empty: any chip, if the line is given by name.
    std::string chip;
    /// The line's offset on its chip, or its name.
    std::variant<unsigned, std::string> line;

    bool operator==(const GpioPlace&) const = default;
};

/// Resistor that holds an undriven input at a level. Chips without such resistors ignore it.
enum class GpioBias { as_is, pull_up, pull_down, none };

/// Accepts `GPIO17` (the line with that name on any chip), `gpiochip0:17` (an offset) and
/// `gpiochip0:GPIO17`; the chip may be a path: `/dev/gpiochip0:17`. The error says what is allowed.
tl::expected<GpioPlace, std::string> parse_gpio_place(std::string_view text);

/// Writes the form that parse_gpio_place reads.
std::string to_text(const GpioPlace& place);

/// Path of the chip's device. Not for a place on any chip.
std::string chip_path(const GpioPlace& place);

}  // namespace tribus
