#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/line_settings.h"
#include "transports/links/unique_fd.h"

namespace tribus::test {

using Bytes = std::vector<std::uint8_t>;

inline constexpr LineSettings kSbus{.baud = 100'000, .parity = Parity::even, .stop_bits = 2};
inline constexpr LineSettings kIbus{.baud = 115'200, .parity = Parity::none, .stop_bits = 1};

/// Line settings of a serial device as its driver reports them (TCGETS2).
struct LineSeen {
    std::uint32_t baud = 0;
    bool parity = false;
    bool two_stop_bits = false;
    bool eight_data_bits = false;
};
LineSeen line_of(int descriptor);

/// A serial device of the guest that the test opens itself: the far end of a wire to the program.
/// Written for the tests and independent of the program's SerialPort.
class Uart {
  public:
    /// Opens the device raw and non-blocking. The test fails if that fails.
    Uart(const std::string& device, const LineSettings& settings);

    /// Sends all bytes and waits for room if necessary.
    void send(std::span<const std::uint8_t> bytes);
    /// Returns what has arrived since the last call. Does not wait.
    Bytes receive();
    /// Waits for `count` bytes. Returns what has arrived when kPatience is over.
    Bytes receive(std::size_t count);

  private:
    UniqueFd fd_;
};

/// Path of a device of the guest (run_guest), such as /dev/ttyUSB0. Devices are numbered 1 and 2 by
/// where they are plugged in; 1 is wired to 2 of the same kind. Waits until the driver has made the
/// device.
std::string ftdi_adapter(int usb_port);
std::string uart_16550(int number);

/// Likewise in the emulated Raspberry Pi (run_raspi3b): the FTDI adapters that are wired to its own
/// ports.
std::string far_end_of_pl011();
std::string far_end_of_mini_uart();

/// Pulls an adapter out of its USB port, as far as its driver can tell, and puts it back.
void unplug_usb(int usb_port);
void plug_usb(int usb_port);

/// The settings that the drivers programmed into the emulated ports since the object was made, from
/// the emulator's trace.
class ProgrammedLines {
  public:
    ProgrammedLines();
    /// Waits until the trace contains `text`. The test fails when kPatience is over.
    void expect(const std::string& text) const;

  private:
    std::string trace() const;
    std::size_t before_ = 0;
};

}  // namespace tribus::test
