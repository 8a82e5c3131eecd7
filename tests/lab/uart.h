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

/// The line settings of a serial device as its driver tells them (TCGETS2).
struct LineSeen {
    std::uint32_t baud = 0;
    bool parity = false;
    bool two_stop_bits = false;
    bool eight_data_bits = false;
};
LineSeen line_of(int descriptor);

/// A serial device of the guest in the test's own hand: the far end of a wire at whose near end
/// the program works. Written again for the tests, independent of the program's SerialPort.
class Uart {
  public:
    /// Raw, non-blocking; the test fails if it cannot be opened.
    Uart(const std::string& device, const LineSettings& settings);

    /// Sends all of it, waiting for room.
    void send(std::span<const std::uint8_t> bytes);
    /// What has come in since the last call; does not wait.
    Bytes receive();
    /// Waits for so many bytes; what has come in when patience ends.
    Bytes receive(std::size_t count);

  private:
    UniqueFd fd_;
};

/// Devices of the guest (run_guest), numbered 1 and 2 by where they are plugged, as /dev/ttyUSB0;
/// waits until their driver has made them. 1 is wired to 2 of the same kind.
std::string ftdi_adapter(int usb_port);
std::string uart_16550(int number);

/// Likewise in the emulated Raspberry Pi (run_raspi3b): the FTDI adapters that are wired to its own
/// ports.
std::string far_end_of_pl011();
std::string far_end_of_mini_uart();

/// Pulls an adapter out of its USB port, as far as its driver can tell, and puts it back.
void unplug_usb(int usb_port);
void plug_usb(int usb_port);

/// What the drivers have programmed into the emulated ports since this object was made: the
/// emulator's own trace.
class ProgrammedLines {
  public:
    ProgrammedLines();
    /// Waits until the trace has this text; the test fails if patience ends.
    void expect(const std::string& text) const;

  private:
    std::string trace() const;
    std::size_t before_ = 0;
};

}  // namespace tribus::test
