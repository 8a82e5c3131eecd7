#include "app/doctor/facts/serial_facts.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/doctor/facts/node_access.h"
#include "app/doctor/facts/port_users.h"

namespace tribus::doctor {
namespace {

namespace fs = std::filesystem;

/// Above a port there are at most a serial-base port and controller, a USB interface and a USB
/// device.
constexpr int kMostLevels = 6;

std::string name_of_link(const fs::path& link) {
    std::error_code error;
    return fs::read_symlink(link, error).filename().string();
}

std::uint32_t hexadecimal(const std::string& text) {
    return static_cast<std::uint32_t>(std::strtoul(text.c_str(), nullptr, 16));
}

/// The path relative to `root`, as KernelFiles expects it.
std::string below_root(const KernelFiles& files, const fs::path& path) {
    std::error_code error;
    return fs::relative(path, fs::canonical(files.at("."), error), error).string();
}

/// Walks up from the port's device to the hardware.
void look_at_hardware(const KernelFiles& files, SerialFacts& facts) {
    auto at = files.target("sys/class/tty/" + facts.name + "/device");
    for (int level = 0; at && level < kMostLevels; ++level, *at = at->parent_path()) {
        const std::string folder = below_root(files, *at) + "/";
        const std::string driver = name_of_link(*at / "driver");
        const bool is_layer = name_of_link(*at / "subsystem") == "serial-base";
        if (facts.driver.empty() && !is_layer) {
            facts.driver = driver;
        }
        if (facts.compatible.empty()) {
            facts.compatible = files.line(folder + "of_node/compatible");
        }
        if (!facts.latency_timer) {
            facts.latency_timer = files.number(folder + "latency_timer");
        }
        if (const std::string number = files.line(folder + "bInterfaceNumber"); !number.empty()) {
            facts.usb.emplace().interface = hexadecimal(number);
        }
        if (files.has(folder + "idVendor")) {
            if (!facts.usb) {
                facts.usb.emplace();
            }
            facts.usb->vendor = hexadecimal(files.line(folder + "idVendor"));
            facts.usb->product = hexadecimal(files.line(folder + "idProduct"));
            facts.usb->release = hexadecimal(files.line(folder + "bcdDevice"));
            facts.usb->product_name = files.line(folder + "product");
            return;
        }
    }
}

/// The kernel's command line has `console=ttyS0,115200n8`; a Raspberry Pi's firmware replaces
/// serial0.
bool is_kernel_console(const KernelFiles& files, const std::string& name) {
    if (files.line("sys/class/tty/" + name + "/console") == "Y") {
        return true;
    }
    const std::string words = " " + files.line("proc/cmdline") + " ";
    for (const char* end : {" ", ","}) {
        if (words.find(fmt::format(" console={}{}", name, end)) != std::string::npos) {
            return true;
        }
    }
    return false;
}

void look_at_node(const KernelFiles& files, SerialFacts& facts) {
    const NodeAccess access = access_to(files, facts.node.substr(1), R_OK | W_OK);
    facts.exists = access.exists;
    if (access.exists) {
        facts.may_open = access.may_open;
        facts.group = access.group;
    }
}

/// The link under /dev/serial to the node: by maker and serial number, or by path if two adapters
/// have the same number.
std::string stable_name(const KernelFiles& files, const std::string& node) {
    const auto target = files.target(node.substr(1));
    for (const std::string_view folder : {"dev/serial/by-id", "dev/serial/by-path"}) {
        for (const std::string& name : files.names_in(folder)) {
            const std::string link = fmt::format("{}/{}", folder, name);
            if (target && files.target(link) == target) {
                return "/" + link;
            }
        }
    }
    return node;
}

SerialFacts look_at(const KernelFiles& files, const std::string& name) {
    SerialFacts facts;
    facts.name = name;
    facts.node = "/dev/" + name;
    facts.pseudo_terminal = name.starts_with("pts/");
    look_at_node(files, facts);
    facts.device = facts.exists ? stable_name(files, facts.node) : facts.node;
    facts.serial = facts.pseudo_terminal || files.has("sys/class/tty/" + name);
    if (!facts.exists || !facts.serial) {
        return facts;
    }
    const std::string folder = "sys/class/tty/" + name + "/";
    facts.uart_type = files.number(folder + "type");
    facts.uart_clock = files.number(folder + "uartclk");
    facts.receive_trigger = files.number(folder + "rx_trig_bytes");
    facts.kernel_console = is_kernel_console(files, name);
    look_at_hardware(files, facts);
    look_at_users(files, facts);
    return facts;
}

bool is_port(const SerialFacts& facts) {
    constexpr std::array<std::string_view, 4> kNoWires{"tty", "console", "ptmx", "ttyprintk"};
    const bool wireless = std::ranges::find(kNoWires, facts.name) != kNoWires.end() ||
                          facts.name.starts_with("hvc") || facts.name.starts_with("rfcomm");
    const bool has_hardware = facts.uart_type.value_or(1) != 0 && !facts.driver.empty();
    return !wireless && has_hardware;
}

}  // namespace

std::vector<SerialFacts> look_at_serial_ports(const KernelFiles& files) {
    std::vector<SerialFacts> ports;
    for (const std::string& name : files.names_in("sys/class/tty")) {
        if (files.has("sys/class/tty/" + name + "/device")) {
            SerialFacts facts = look_at(files, name);
            if (is_port(facts)) {
                ports.push_back(std::move(facts));
            }
        }
    }
    return ports;
}

SerialFacts look_at_serial_port(const KernelFiles& files, const std::string& device) {
    const std::string path = device.starts_with('/') ? device.substr(1) : device;
    const auto target = files.target(path);
    const std::string below = target ? "/" + below_root(files, *target) : "/" + path;
    constexpr std::string_view kDevices = "/dev/";
    if (!target || !below.starts_with(kDevices)) {
        SerialFacts facts;
        facts.name = fs::path(device).filename().string();
        facts.device = device;
        facts.node = target ? below : device;
        facts.serial = false;
        look_at_node(files, facts);
        return facts;
    }
    return look_at(files, below.substr(kDevices.size()));
}

}  // namespace tribus::doctor
