#include "transports/links/serial/uart_rate.h"

#include <algorithm>
#include <cstdint>
#include <string>

namespace tribus {

namespace {

// linux/major.h: UNIX98_PTY_SLAVE_MAJOR and the seven majors after it.
constexpr std::uint32_t kFirstPtyMajor = 136;
constexpr std::uint32_t kLastPtyMajor = 143;
// Documentation/admin-guide/devices.txt: char major 4 is tty0 to tty63, then ttyS0 and up.
constexpr std::uint32_t kTtyMajor = 4;
constexpr std::uint32_t kFirstTtySMinor = 64;
// linux/serial_core.h: PORT_AMBA. A PL011 has a fractional divisor, so whole divisors of its
// baud_base prove nothing (docs/protocols/sbus.md, "Serial port: bit rate").
constexpr int kPl011PortType = 32;

bool divides_by_whole_numbers(const PortFacts& facts) {
    return facts.device_major == kTtyMajor && facts.device_minor >= kFirstTtySMinor &&
           facts.driver && facts.driver->type != kPl011PortType && facts.driver->baud_base > 0;
}

std::uint32_t rate_at_divisor(std::uint32_t baud_base, std::uint64_t divisor) {
    return static_cast<std::uint32_t>((2ULL * baud_base + divisor) / (2 * divisor));
}

std::uint64_t difference(std::uint64_t a, std::uint64_t b) {
    return std::max(a, b) - std::min(a, b);
}

std::string percent_off(std::uint32_t actual, std::uint32_t asked) {
    const std::uint64_t tenths = (difference(actual, asked) * 1000 + asked / 2) / asked;
    return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " %";
}

std::string what_it_can_do(const PortFacts& facts) {
    if (!divides_by_whole_numbers(facts)) {
        return "that is the nearest rate that its driver can set";
    }
    const std::uint32_t base = facts.driver->baud_base;
    const std::string divides =
        "this UART divides " + std::to_string(base) + " baud by whole numbers";
    const std::uint64_t divisor = base / facts.asked.baud;
    if (divisor == 0) {
        return divides + " and cannot go faster";
    }
    return divides + ", its nearest rates are " +
           std::to_string(rate_at_divisor(base, divisor + 1)) + " and " +
           std::to_string(rate_at_divisor(base, divisor));
}

bool rate_is_off(const PortFacts& facts) {
    return difference(wire_baud(facts), facts.asked.baud) * 1000 >
           std::uint64_t{facts.asked.baud} * kMostRateErrorPerMille;
}

/// The rates of SBUS are fixed. Receivers of other protocols can often be set to another.
std::string advice_on_rate(std::uint32_t asked) {
    constexpr std::uint32_t kSbusBaud = 100'000;
    if (asked == kSbusBaud || asked == 2 * kSbusBaud) {
        return "use a port that can: a USB adapter with an FTDI FT232R or a PL011 of the board "
               "(ttyAMA) does 100000 and 200000 baud, a CP2102 or a PC's 16550 does not";
    }
    return "set the device at the other end, and `baud`, to a rate that this port can do (115200 "
           "works on nearly every one), or use a USB adapter with an FTDI FT232R or a PL011 of the "
           "board (ttyAMA)";
}

std::string rate_refusal(const PortFacts& facts) {
    const std::uint32_t actual = wire_baud(facts);
    return "asked for " + std::to_string(facts.asked.baud) + " baud, but the port runs at " +
           std::to_string(actual) + ", " + percent_off(actual, facts.asked.baud) +
           " off (at most 1.5 % works); " + what_it_can_do(facts) + "; " +
           advice_on_rate(facts.asked.baud);
}

std::string parity_refusal(const PortFacts& facts) {
    if (facts.asked.parity == Parity::none) {
        return "asked for no parity bit, but the port puts one on the wire; use another port";
    }
    return "asked for even parity, but the port drops the parity bit; a Raspberry Pi's mini UART "
           "(ttyS0, ttyS1) has no parity at all: use a PL011 of the board (ttyAMA) or a USB "
           "adapter with an FTDI FT232R";
}

}  // namespace

bool is_pseudo_terminal(std::uint32_t device_major) {
    return device_major >= kFirstPtyMajor && device_major <= kLastPtyMajor;
}

std::uint32_t wire_baud(const PortFacts& facts) {
    if (!divides_by_whole_numbers(facts) || facts.reported_baud == 0) {
        return facts.reported_baud;
    }
    const std::uint64_t base = facts.driver->baud_base;
    const std::uint64_t reported = facts.reported_baud;
    // The kernel rounds the divisor to the nearest whole number, halves upwards.
    const std::uint64_t divisor =
        std::max<std::uint64_t>(1, (2 * base + reported) / (2 * reported));
    return rate_at_divisor(facts.driver->baud_base, divisor);
}

std::optional<std::string> port_refusal(const PortFacts& facts) {
    if (facts.asked.baud == 0) {
        return "asked for 0 baud; give a rate above 0";
    }
    if (rate_is_off(facts)) {
        return rate_refusal(facts);
    }
    // A pty keeps neither parity nor size and needs neither, since its bytes are never on a wire.
    if (is_pseudo_terminal(facts.device_major)) {
        return std::nullopt;
    }
    if (!facts.parity_kept) {
        return parity_refusal(facts);
    }
    if (!facts.stop_bits_kept) {
        return "asked for " + std::to_string(facts.asked.stop_bits) +
               " stop bits, but the port does not keep that; use another port";
    }
    if (!facts.data_bits_kept) {
        return "asked for 8 data bits, but the port does not keep that; use another port";
    }
    return std::nullopt;
}

}  // namespace tribus
