#include "app/doctor/port_kind.h"

#include <array>
#include <cstdint>
#include <string_view>

#include <fmt/format.h>

#include "app/doctor/listening/line_heard.h"
#include "transports/links/serial/uart_rate.h"

namespace tribus::doctor {
namespace {

constexpr std::uint32_t kSixteenth = 16;

/// From bcdDevice, by which ftdi_sio distinguishes its chips.
std::string ftdi_chip(const UsbFacts& usb) {
    struct Chip {
        std::uint32_t release;
        std::string_view name;
    };
    constexpr std::array<Chip, 7> kChips{{{0x0400, "FT232BM"},
                                          {0x0500, "FT2232C"},
                                          {0x0600, "FT232R"},
                                          {0x0700, "FT2232H"},
                                          {0x0800, "FT4232H"},
                                          {0x0900, "FT232H"},
                                          {0x1000, "FT-X"}}};
    for (const Chip& chip : kChips) {
        if (chip.release == usb.release) {
            return fmt::format("USB adapter, FTDI {}", chip.name);
        }
    }
    return "USB adapter, FTDI";
}

/// The kernel does not publish the part number of the chip; product names of the makers contain it.
/// Only the first port of a CP2105 sets any rate.
PortKind silicon_labs(const UsbFacts& usb) {
    const std::string& name = usb.product_name;
    const auto named = [&](std::string_view part) { return name.find(part) != std::string::npos; };
    PortKind kind{.name = fmt::format("USB adapter, Silicon Labs {}", name), .usb = true};
    const bool free =
        named("CP2102N") || named("CP2104") || (named("CP2105") && usb.interface == 0);
    const bool known = free || named("CP2101") || named("CP2102") || named("CP2103") ||
                       named("CP2105") || named("CP2108");
    kind.quantises_rates = known && !free;
    if (!known) {
        kind.rates_unknown = true;
        kind.rates_note =
            "a CP2102N or CP2104 can, a CP2102 cannot, and the adapter does not say which one it "
            "is";
    }
    return kind;
}

PortKind usb_kind(const SerialFacts& facts, const UsbFacts& usb) {
    if (facts.driver == "ftdi_sio") {
        return {.name = ftdi_chip(usb), .usb = true};
    }
    if (facts.driver == "cp210x") {
        return silicon_labs(usb);
    }
    if (facts.driver == "ch341" || facts.driver == "ch341-uart") {
        return {.name = "USB adapter, WCH CH340 or CH341",
                .rates_note = "by its driver's source; not tried",
                .usb = true};
    }
    if (facts.driver == "pl2303") {
        return {.name = "USB adapter, Prolific PL2303",
                .rates_unknown = true,
                .rates_note = "its versions and copies differ",
                .usb = true};
    }
    if (facts.driver == "cdc_acm") {
        return {.name = fmt::format("USB device {}", usb.product_name),
                .rates_unknown = true,
                .rates_note = "its firmware decides what rate and parity do",
                .usb = true};
    }
    return {.name = fmt::format("USB device {} ({})", usb.product_name, facts.driver),
            .rates_unknown = true,
            .rates_note = "its driver is not known here",
            .usb = true};
}

bool is_mini_uart(const SerialFacts& facts) {
    return facts.driver == "bcm2835-aux-uart" ||
           facts.compatible.find("brcm,bcm2835-aux-uart") != std::string::npos;
}

bool is_16550(const SerialFacts& facts) {
    return facts.name.starts_with("ttyS") && facts.uart_clock && *facts.uart_clock > 0;
}

}  // namespace

PortKind kind_of(const SerialFacts& facts) {
    if (facts.pseudo_terminal) {
        return {.name = "pseudo-terminal"};
    }
    if (facts.usb) {
        return usb_kind(facts, *facts.usb);
    }
    if (is_mini_uart(facts)) {
        return {.name = "mini UART of a Raspberry Pi",
                .parity = false,
                .rates_note = "its rate follows the core clock"};
    }
    if (facts.driver == "uart-pl011") {
        return {.name = "PL011 of the board"};
    }
    if (facts.driver.find("tegra") != std::string::npos) {
        return {
            .name = fmt::format("UART of the board ({})", facts.driver),
            .rates_unknown = true,
            .rates_note = "its driver reports the requested rate even if it failed: check `dmesg`"};
    }
    // Such a driver may change the clock with the rate (Rockchip) or not (Allwinner).
    const bool sets_clock = facts.driver == "dw-apb-uart";
    if (is_16550(facts) && !sets_clock) {
        return {.name = fmt::format("16550 at {} baud ({})", *facts.uart_clock / kSixteenth,
                                    facts.driver)};
    }
    return {.name = fmt::format("UART of the board ({})", facts.driver),
            .rates_unknown = true,
            .rates_note = "its driver decides the rates"};
}

std::optional<std::string> hardware_refusal(const PortKind& kind, const SerialFacts& facts,
                                            const LineSettings& line) {
    if (!kind.parity && line.parity != Parity::none) {
        return "it has no parity bit";
    }
    if (kind.quantises_rates && line.baud != kUsualBaud) {
        return fmt::format("it sets {} baud instead of {}",
                           line.baud == 100'000 ? 115'200 : 230'400, line.baud);
    }
    if (kind.usb || kind.rates_unknown || !is_16550(facts) || !kind.parity) {
        return std::nullopt;
    }
    constexpr std::uint32_t kTtySMajor = 4;
    constexpr std::uint32_t kTtySMinor = 64;
    const PortFacts port{
        .device_major = kTtySMajor,
        .device_minor = kTtySMinor,
        .asked = line,
        .reported_baud = line.baud,
        .driver = SerialDriverFacts{static_cast<int>(facts.uart_type.value_or(0)),
                                    static_cast<std::uint32_t>(*facts.uart_clock / kSixteenth)}};
    if (!port_refusal(port)) {
        return std::nullopt;
    }
    return fmt::format("it would run at {} baud", wire_baud(port));
}

}  // namespace tribus::doctor
