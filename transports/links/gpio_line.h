#pragma once

#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "transports/links/gpio_place.h"

/// GPIO lines, held by this program alone. `open` blocks for as long as the driver takes, and its
/// error begins with the place and says what to do. The other calls are one or two system calls
/// without heap; a line on an I2C or USB expander waits for its bus in them: not for the data
/// thread. Thread-bound.
///
/// A line that is given back, also by the death of the process, keeps its level or falls back to
/// its resistor: that is up to its chip. A chip that is pulled out while a line of it is held comes
/// back under another number, so only a place by name finds it again.
namespace tribus {

class GpioHeldLine;

class GpioOutput {
  public:
    /// The line has the level of `active_at_start` from its first moment as an output.
    static tl::expected<std::unique_ptr<GpioOutput>, std::string> open(const GpioPlace& place,
                                                                       bool active_low,
                                                                       bool active_at_start);
    ~GpioOutput();

    /// False if the line did not take it: the chip is gone, or its bus does not answer. The line
    /// of a chip that came back has to be opened anew.
    bool set(bool active);

  private:
    explicit GpioOutput(std::unique_ptr<GpioHeldLine> line);
    std::unique_ptr<GpioHeldLine> line_;
};

class GpioInput {
  public:
    static tl::expected<std::unique_ptr<GpioInput>, std::string> open(const GpioPlace& place,
                                                                      bool active_low,
                                                                      GpioBias bias);
    ~GpioInput();

    /// Readable from an edge on until the next `read`, for poll and epoll. Also if the chip is
    /// gone, but Linux 6.1 does not wake who is already waiting: wait with a timeout.
    int descriptor() const;
    /// Forgets the edges so far and gives the level now; nothing if the chip is gone or its bus
    /// does not answer.
    std::optional<bool> read();

  private:
    explicit GpioInput(std::unique_ptr<GpioHeldLine> line);
    std::unique_ptr<GpioHeldLine> line_;
};

}  // namespace tribus
