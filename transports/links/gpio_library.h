#pragma once

#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "transports/links/gpio_search.h"

/// What differs between the versions 1 and 2 of libgpiod, behind one face: gpio_library_v1.cpp and
/// gpio_library_v2.cpp, of which the build takes the one for the library that it finds. Errors are
/// values of errno.
namespace tribus {

/// A line that this program holds; given back with this object. Thread-bound.
class GpioHeldLine {
  public:
    GpioHeldLine() = default;
    GpioHeldLine(const GpioHeldLine&) = delete;
    GpioHeldLine& operator=(const GpioHeldLine&) = delete;
    virtual ~GpioHeldLine() = default;

    /// False if the kernel did not take it.
    virtual bool set(bool active) = 0;
    /// Nothing if the kernel does not tell.
    virtual std::optional<bool> get() const = 0;
    virtual int descriptor() const = 0;
};

struct GpioRequest {
    unsigned offset = 0;
    GpioUse use = GpioUse::input;
    bool active_low = false;
    bool active_at_start = false;     ///< of an output
    GpioBias bias = GpioBias::as_is;  ///< of an input, which tells both its edges
};

/// Who the kernel says holds the line.
inline constexpr const char* kGpioConsumer = "tribus";

tl::expected<std::vector<GpioLineFacts>, int> read_gpio_lines(const std::string& chip_path);
tl::expected<std::unique_ptr<GpioHeldLine>, int> request_gpio_line(const std::string& chip_path,
                                                                   const GpioRequest& request);

}  // namespace tribus
