#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "transports/links/gpio/gpio_search.h"

/// Common interface of versions 1 and 2 of libgpiod. The build takes gpio_library_v1.cpp or
/// gpio_library_v2.cpp, for the version that it finds. Errors are values of errno.
namespace tribus {

/// An edge of a line, as the kernel saw it.
struct GpioEdge {
    std::uint64_t nanoseconds = 0;  ///< on the monotonic clock
    bool after_loss = false;        ///< edges before this one were, or may be, lost
};

/// Most edges that one read takes: as many as version 1 of the kernel's interface keeps.
inline constexpr std::size_t kEdgesPerRead = 16;

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
    /// Takes the edges that wait, at most `edges.size()`, which is at least kEdgesPerRead. The
    /// descriptor must not block. Returns how many they are; nothing if the chip is gone. One
    /// system call, no heap.
    virtual std::optional<std::size_t> read_edges(std::span<GpioEdge> edges) = 0;
};

/// Which edges an input reports. Of a line that is active when low, rising is active to inactive.
enum class GpioEdges : std::uint8_t { both, rising, falling };

struct GpioRequest {
    unsigned offset = 0;
    GpioUse use = GpioUse::input;
    bool active_low = false;
    bool active_at_start = false;       ///< output only
    GpioBias bias = GpioBias::as_is;    ///< input only
    GpioEdges edges = GpioEdges::both;  ///< input only
};

/// Name under which the kernel shows the line's user.
inline constexpr const char* kGpioConsumer = "tribus";

/// Reads the description of a chip's lines. May block.
tl::expected<std::vector<GpioLineFacts>, int> read_gpio_lines(const std::string& chip_path);
/// Requests a line. May block.
tl::expected<std::unique_ptr<GpioHeldLine>, int> request_gpio_line(const std::string& chip_path,
                                                                   const GpioRequest& request);

}  // namespace tribus
