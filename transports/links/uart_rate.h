#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/line_settings.h"

namespace tribus {

/// What TIOCGSERIAL tells of a port.
struct SerialDriverFacts {
    int type = 0;
    /// Rate at divisor 1, in baud.
    std::uint32_t baud_base = 0;
};

/// All that is known of a port after its line settings were set and read back.
struct PortFacts {
    /// Numbers of the device node (st_rdev).
    std::uint32_t device_major = 0;
    std::uint32_t device_minor = 0;
    LineSettings asked;
    /// What the read-back says; not always what the wire has, see `wire_baud`.
    std::uint32_t reported_baud = 0;
    bool parity_kept = true;
    bool stop_bits_kept = true;
    bool data_bits_kept = true;
    /// Absent where the driver does not answer (ptys).
    std::optional<SerialDriverFacts> driver;
};

/// Twelve bits a character leave room for half a bit in all; both ends share it.
inline constexpr std::uint32_t kMostRateErrorPerMille = 15;

/// A Unix98 pty: it has no wire, so no parity bit and no rate that could be wrong.
bool is_pseudo_terminal(std::uint32_t device_major);

/// The rate that the wire has, in baud, as far as the port tells. A 16550 (8250 driver, ttyS)
/// reports the request but runs at baud_base divided by a whole number, which this computes. Of
/// other drivers it returns what they report: cp210x the rate that is set; ftdi_sio and the PL011
/// the request, which their finer divisors come close to (docs/protocols/sbus.md, "Serial port: bit
/// rate"). Pure and reentrant.
std::uint32_t wire_baud(const PortFacts& facts);

/// Why the port cannot serve and what to do about it; nothing if it can. Does not name the
/// device. Pure and reentrant.
std::optional<std::string> port_refusal(const PortFacts& facts);

}  // namespace tribus
