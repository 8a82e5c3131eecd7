#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/doctor/kernel_files.h"

namespace tribus::doctor {

struct UsbFacts {
    std::uint32_t vendor = 0;
    std::uint32_t product = 0;
    std::uint32_t release = 0;  ///< bcdDevice: FTDI's chips differ by it
    std::uint32_t interface = 0;
    std::string product_name;
};

/// A process that has a port open, or a login that waits for it.
struct PortUser {
    pid_t process = 0;
    std::string command;
    std::string unit;  ///< of systemd: "serial-getty@ttyS0.service"; empty where it has none
    bool is_login = false;
};

/// What is known of a serial port without opening it; what nobody tells is empty.
struct SerialFacts {
    std::string name;    ///< of the kernel: "ttyUSB0", "pts/3"
    std::string device;  ///< that a configuration had best name: by its adapter where there is one
    std::string node;    ///< "/dev/ttyUSB0"
    bool exists = true;
    bool serial = true;  ///< the kernel knows it as a terminal's line
    bool pseudo_terminal = false;
    /// Of the hardware itself, below the layers that Linux 6.5 and later put in between.
    std::string driver;
    std::string compatible;  ///< all names of the device tree, with spaces between
    std::optional<UsbFacts> usb;

    std::optional<std::int64_t> uart_type;        ///< 0: no hardware was found behind the node
    std::optional<std::int64_t> uart_clock;       ///< Hz
    std::optional<std::int64_t> receive_trigger;  ///< bytes in the FIFO before it tells
    std::optional<std::int64_t> latency_timer;    ///< ms

    bool kernel_console = false;
    std::vector<PortUser> users;
    /// Processes of others whose open files may not be looked at.
    bool users_hidden = false;
    bool may_open = true;
    bool was_opened = false;  ///< by this program, before the rest was looked at
    std::string group;        ///< of the node
};

/// Every port that has hardware: no virtual terminals, no 8250 ports of which the kernel found
/// none.
std::vector<SerialFacts> look_at_serial_ports(const KernelFiles& files);

/// The port that a path names, by links as under /dev/serial/by-id too.
SerialFacts look_at_serial_port(const KernelFiles& files, const std::string& device);

}  // namespace tribus::doctor
