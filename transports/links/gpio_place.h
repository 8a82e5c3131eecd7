#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>

/// Which GPIO line, as people write it. Pure and reentrant.
namespace tribus {

struct GpioPlace {
    /// "gpiochip0", or a path; empty: any chip, which takes a name.
    std::string chip;
    /// The line's offset on its chip, or the name that the board gives it.
    std::variant<unsigned, std::string> line;

    bool operator==(const GpioPlace&) const = default;
};

/// What holds an input at a level while nothing drives it. Chips without such resistors ignore it.
enum class GpioBias { as_is, pull_up, pull_down, none };

/// `GPIO17` (the line of that name on any chip), `gpiochip0:17` (an offset), `gpiochip0:GPIO17`;
/// a chip may be a path: `/dev/gpiochip0:17`. The error says what is allowed.
tl::expected<GpioPlace, std::string> parse_gpio_place(std::string_view text);

/// In the same form.
std::string to_text(const GpioPlace& place);

/// Of the chip's device. Not for a place on any chip.
std::string chip_path(const GpioPlace& place);

}  // namespace tribus
