#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/doctor/facts/kernel_files.h"

namespace tribus::doctor {

struct UsbFacts {
    std::uint32_t vendor = 0;
    std::uint32_t product = 0;
    std::uint32_t release = 0;  ///< bcdDevice, which distinguishes FTDI's chips
    std::uint32_t interface = 0;
    std::string product_name;
};

/// A process that has a port open, or a login that waits for it.
struct PortUser {
    pid_t process = 0;
    std::string command;
    std::string unit;  ///< systemd unit: "serial-getty@ttyS0.service"; may be empty
    bool is_login = false;
};

/// Facts about a serial port, found without opening it; unknown ones are empty.
struct SerialFacts {
    std::string name;    ///< kernel name: "ttyUSB0", "pts/3"
    std::string device;  ///< best name for a configuration: by adapter, if there is one
    std::string node;    ///< "/dev/ttyUSB0"
    bool exists = true;
    bool serial = true;  ///< the kernel knows it as a tty
    bool pseudo_terminal = false;
    /// Driver of the hardware, below the layers that Linux 6.5 and later insert.
    std::string driver;
    std::string compatible;  ///< all names in the device tree, separated by blanks
    std::optional<UsbFacts> usb;

    std::optional<std::int64_t> uart_type;        ///< 0: no hardware behind the node
    std::optional<std::int64_t> uart_clock;       ///< Hz
    std::optional<std::int64_t> receive_trigger;  ///< bytes in the FIFO before it reports
    std::optional<std::int64_t> latency_timer;    ///< ms

    bool kernel_console = false;
    std::vector<PortUser> users;
    /// There are processes of other users whose open files cannot be read.
    bool users_hidden = false;
    bool may_open = true;
    bool was_opened = false;  ///< by this program, before the timer was read
    std::string group;        ///< group of the node
};

/// All ports with hardware: no virtual terminals, no 8250 ports without a UART.
std::vector<SerialFacts> look_at_serial_ports(const KernelFiles& files);

/// The port at a path; follows links such as those in /dev/serial/by-id.
SerialFacts look_at_serial_port(const KernelFiles& files, const std::string& device);

}  // namespace tribus::doctor
