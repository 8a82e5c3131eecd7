#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "core/time.h"
#include "transports/links/gpio/gpio_place.h"
#include "transports/links/gpio/gpio_search.h"

/// GPIO lines, used by this program alone. `open` blocks as long as the driver needs; its error
/// begins with the place and says what to do. The other calls are one or two system calls without
/// heap. On an I2C or USB expander they wait for its bus, so they are not for the data thread.
/// Thread-bound.
///
/// A released line, also after the death of the process, keeps its level or falls back to its
/// resistor, depending on the chip. A chip that is unplugged while one of its lines is held returns
/// with another number, so only a place by name finds it again.
namespace tribus {

class GpioHeldLine;
enum class GpioEdges : std::uint8_t;

/// Whether no chip has that name now, or no line of any chip; false if this user may not look. May
/// block.
bool is_gpio_line_absent(const GpioPlace& place);

/// The GPIO chips of this machine with their lines, in the order of their numbers; or a value of
/// errno if /dev cannot be read. May block.
tl::expected<std::vector<GpioChip>, int> find_gpio_chips();

/// Path of the place's chip, with symbolic links resolved if it exists; empty for any chip. May
/// block.
std::string followed_chip_path(const GpioPlace& place);

/// Holds an input that gives each edge with its time, by a descriptor that does not block. The
/// error is that of `GpioInput::open`.
tl::expected<std::unique_ptr<GpioHeldLine>, std::string> hold_for_edges(const GpioPlace& place,
                                                                        GpioEdges edges,
                                                                        GpioBias bias);

/// An output line.
class GpioOutput {
  public:
    /// The line has the level of `active_at_start` as soon as it is an output.
    static tl::expected<std::unique_ptr<GpioOutput>, std::string> open(const GpioPlace& place,
                                                                       bool active_low,
                                                                       bool active_at_start);
    /// `line` is an output.
    explicit GpioOutput(std::unique_ptr<GpioHeldLine> line);
    ~GpioOutput();

    /// Returns false if the line did not change: the chip is gone, or its bus does not answer. A
    /// line of a chip that returned must be opened again.
    bool set(bool active);

  private:
    std::unique_ptr<GpioHeldLine> line_;
};

/// An input line that reports its edges.
class GpioInput {
  public:
    static tl::expected<std::unique_ptr<GpioInput>, std::string> open(const GpioPlace& place,
                                                                      bool active_low,
                                                                      GpioBias bias);
    /// `line` is an input that reports both edges, and its descriptor does not block.
    explicit GpioInput(std::unique_ptr<GpioHeldLine> line);
    ~GpioInput();

    /// Readable from an edge until the next `read`, for poll and epoll. Also readable if the chip
    /// is gone, but Linux 6.1 does not wake a waiting program then: wait with a timeout.
    int descriptor() const;
    /// Clears the edges so far and returns the present level; nothing if the chip is gone or its
    /// bus does not answer.
    std::optional<bool> read();
    /// When the latest edge came that the latest `read` cleared, on CLOCK_MONOTONIC; nothing if it
    /// cleared none. `Duration::max()`: unknown, the kernel may have dropped edges.
    std::optional<Duration> latest_edge() const { return latest_edge_; }

  private:
    std::unique_ptr<GpioHeldLine> line_;
    std::optional<Duration> latest_edge_;
};

}  // namespace tribus
