#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/line_settings.h"

namespace tribus {

/// What TIOCGSERIAL reports about a port.
struct SerialDriverFacts {
    int type = 0;
    /// Rate at divisor 1, in baud.
    std::uint32_t baud_base = 0;
};

/// Known facts about a port after its line settings were set and read back.
struct PortFacts {
    /// Numbers of the device node (st_rdev).
    std::uint32_t device_major = 0;
    std::uint32_t device_minor = 0;
    LineSettings asked;
    /// The rate that was read back; not always that of the wire, see `wire_baud`.
    std::uint32_t reported_baud = 0;
    bool parity_kept = true;
    bool stop_bits_kept = true;
    bool data_bits_kept = true;
    /// Absent if the driver does not answer (ptys).
    std::optional<SerialDriverFacts> driver;
};

/// Largest rate error that works, in per mille. Over the twelve bits of a character, both ends
/// together may be off by half a bit.
inline constexpr std::uint32_t kMostRateErrorPerMille = 15;

/// Whether it is a Unix98 pty: it has no wire, so no parity bit and no rate that could be wrong.
/// Pure and reentrant.
bool is_pseudo_terminal(std::uint32_t device_major);

/// The rate on the wire in baud, as far as the port reveals it. A 16550 (8250 driver, ttyS) reports
/// the requested rate but runs at baud_base divided by a whole number, which this computes. For
/// other drivers it returns the reported rate: cp210x reports the real one; ftdi_sio and the PL011
/// report the requested one, which their finer divisors nearly meet (docs/protocols/sbus.md,
/// "Serial port: bit rate"). Pure and reentrant.
std::uint32_t wire_baud(const PortFacts& facts);

/// Why the port is unusable and what to do; nothing if it is usable. Does not name the device. Pure
/// and reentrant.
std::optional<std::string> port_refusal(const PortFacts& facts);

}  // namespace tribus
