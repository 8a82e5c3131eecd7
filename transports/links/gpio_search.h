#pragma once

#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "transports/links/gpio_place.h"

/// What the kernel tells about GPIO lines, and what it means to the one who asked for a line. Pure
/// and reentrant. Errors are values of errno.
namespace tribus {

struct GpioLineFacts {
    std::string name;  ///< empty if it has none
    bool used = false;
    std::string consumer;  ///< by whom, empty if the kernel does not tell
};

struct GpioChip {
    std::string path;
    int error = 0;  ///< why its lines are not known
    std::vector<GpioLineFacts> lines;
};

/// A line of one of the chips that were searched.
struct GpioFinding {
    const GpioChip& chip;
    unsigned offset = 0;
};

/// The one line that is meant, of all the machine's chips. `chip_path` is the path of the place's
/// chip without symbolic links, empty for any chip. The error does not repeat the place.
tl::expected<GpioFinding, std::string> find_gpio_line(const GpioPlace& place,
                                                      std::string_view chip_path,
                                                      std::span<const GpioChip> chips);

enum class GpioUse { output, input };

/// Why the kernel did not hand out the line, and what to do.
std::string gpio_refusal(int error, const GpioLineFacts& line, GpioUse use, GpioBias bias);

}  // namespace tribus
