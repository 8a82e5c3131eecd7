#pragma once

#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "transports/links/gpio/gpio_search.h"

/// Common interface of versions 1 and 2 of libgpiod. The build takes gpio_library_v1.cpp or
/// gpio_library_v2.cpp, for the version that it finds. Errors are values of errno.
namespace tribus {

/// A GPIO line held by this program; released with this object. Thread-bound.
class GpioHeldLine {
  public:
    GpioHeldLine() = default;
    GpioHeldLine(const GpioHeldLine&) = delete;
    GpioHeldLine& operator=(const GpioHeldLine&) = delete;
    virtual ~GpioHeldLine() = default;

    /// Returns false if the kernel refused.
    virtual bool set(bool active) = 0;
    /// Returns nothing if the kernel gives no level.
    virtual std::optional<bool> get() const = 0;
    virtual int descriptor() const = 0;
};

struct GpioRequest {
    unsigned offset = 0;
    GpioUse use = GpioUse::input;
    bool active_low = false;
    bool active_at_start = false;     ///< output only
    GpioBias bias = GpioBias::as_is;  ///< input only; an input reports both edges
};

/// Name under which the kernel shows the line's user.
inline constexpr const char* kGpioConsumer = "tribus";

/// Reads the description of a chip's lines. May block.
tl::expected<std::vector<GpioLineFacts>, int> read_gpio_lines(const std::string& chip_path);
/// Requests a line. May block.
tl::expected<std::unique_ptr<GpioHeldLine>, int> request_gpio_line(const std::string& chip_path,
                                                                   const GpioRequest& request);

}  // namespace tribus
