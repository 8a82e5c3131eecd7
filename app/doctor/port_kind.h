#pragma once

#include <optional>
#include <string>

#include "app/doctor/serial_facts.h"
#include "core/line_settings.h"

namespace tribus::doctor {

/// What a kind of hardware makes of line settings.
struct PortKind {
    std::string name;
    bool parity = true;
    /// Its driver, or the device behind it, settles what rates there are, and does not say.
    bool rates_unknown = false;
    std::string rates_note{};      ///< why, or what to know of its rates
    bool quantises_rates = false;  ///< to the table of Silicon Labs' AN205, which has no 100000
    bool usb = false;
};

PortKind kind_of(const SerialFacts& facts);

/// Why the hardware cannot serve with these settings; nothing if it can, as far as is known.
std::optional<std::string> hardware_refusal(const PortKind& kind, const SerialFacts& facts,
                                            const LineSettings& line);

}  // namespace tribus::doctor
