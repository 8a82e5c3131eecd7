#pragma once

#include <optional>
#include <string>

#include "app/doctor/facts/serial_facts.h"
#include "core/line_settings.h"

namespace tribus::doctor {

/// What a kind of port can do with line settings.
struct PortKind {
    std::string name;
    bool parity = true;
    /// The driver or device decides which rates exist and does not report them.
    bool rates_unknown = false;
    std::string rates_note{};  ///< a reason, or a remark on its rates
    bool quantises_rates =
        false;  ///< rounds to the table of Silicon Labs' AN205, which has no 100000
    bool usb = false;
};

/// The kind of a port, from its driver and USB data. Pure.
PortKind kind_of(const SerialFacts& facts);

/// Why the hardware cannot use these settings; nothing if it can, as far as known.
std::optional<std::string> hardware_refusal(const PortKind& kind, const SerialFacts& facts,
                                            const LineSettings& line);

}  // namespace tribus::doctor
