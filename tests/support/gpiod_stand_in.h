#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/own_dev.h"

namespace tribus::test {

/// A GPIO line before a program requests it.
struct StandInLine {
    std::string name{};      ///< empty: it has none
    std::string consumer{};  ///< who has it; empty: nobody
    bool used = false;       ///< by somebody whom the kernel does not name
    bool high = false;       ///< the level on the wire
    int refusal = 0;         ///< with which errno it is refused to who requests it
    int undescribed = 0;     ///< with which errno its description is
};

/// A chip of GPIO lines for version 1.6 of libgpiod without a kernel that has one. Linked before
/// the library, gpiod_stand_in.cpp defines those of its functions that transports/links/gpio calls.
/// They do this of what the library and the kernel do:
///
/// - A chip is opened by its path, many times. Unknown paths give ENOENT.
/// - A line is described as it is at that moment. Who holds it is its consumer.
/// - A line that is held or used gives EBUSY to others, and is free again when its chip is closed.
/// - An output has its first level at once. Its level and that of an input are those on the wire,
///   or the opposite ones on a line that is active when low.
/// - An input that was requested with edges has a descriptor, which blocks at first. Each edge of
///   the requested kind that comes is an event there, with its time; 16 wait at most, and further
///   ones are lost. On a line that is active when low, rising is from high to low on the wire.
/// - Of a chip that was unplugged each call fails, and each read of a descriptor. The errno of that
///   read is another one than the kernel's.
///
/// Resistors do nothing. The library's checks of wrong calls, its other functions and all that
/// concerns several lines at a time are not there. The file in /dev is an ordinary device.
class GpioChipStandIn {
  public:
    struct State;

    /// `name`: such as "gpiochip0".
    GpioChipStandIn(const std::string& name, std::vector<StandInLine> lines);
    ~GpioChipStandIn();

    /// From now on it cannot be opened, with this errno.
    void refuse(int error);
    void unplug();

    bool is_high(unsigned line) const;
    /// Moves the wire. An edge has come at `nanoseconds`.
    void drive(unsigned line, bool high, std::uint64_t nanoseconds = 1);
    /// Reads of the line's descriptor give no bytes any more, and no error.
    void end_events(unsigned line);
    /// The line does not answer any more: it has no level and takes none.
    void silence(unsigned line);
    /// The request, such as "tribus: output, active-low"; empty if nobody holds the line.
    std::string requested(unsigned line) const;
    /// How often it is open now.
    int open_count() const;

  private:
    std::shared_ptr<State> state_;
    DeviceFile device_;
};

}  // namespace tribus::test
