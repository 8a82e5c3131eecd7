#pragma once

#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "transports/links/gpio/gpio_place.h"

/// Finds a GPIO line in the kernel's description and explains refusals. Pure and reentrant. Errors
/// are values of errno.
namespace tribus {

/// A GPIO line as the kernel describes it.
struct GpioLineFacts {
    std::string name{};  ///< empty if it has none
    bool used = false;
    std::string consumer{};  ///< its user, empty if the kernel does not say
};

/// A GPIO chip with its lines.
struct GpioChip {
    std::string path{};
    int error = 0;  ///< why its lines are unknown
    std::vector<GpioLineFacts> lines{};
};

/// A line of one of the searched chips.
struct GpioFinding {
    const GpioChip& chip;
    unsigned offset = 0;
};

/// Finds the line among all chips of the machine. `chip_path` is the path of the place's chip with
/// symbolic links resolved, empty for any chip. The error does not repeat the place.
tl::expected<GpioFinding, std::string> find_gpio_line(const GpioPlace& place,
                                                      std::string_view chip_path,
                                                      std::span<const GpioChip> chips);

enum class GpioUse { output, input };

/// Why the kernel refused the line, and what to do.
std::string gpio_refusal(int error, const GpioLineFacts& line, GpioUse use, GpioBias bias);

}  // namespace tribus
