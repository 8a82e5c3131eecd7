#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "app/journal/log.h"
#include "core/time.h"

namespace tribus {

/// A change of state with its sentence, as all get it who tell changes.
struct ToldChange {
    std::uint64_t number = 0;  ///< 1 for the first change since the start of the program, and so on
    Instant at{};
    Duration wall_time{};  ///< the same since 1970
    /// "input", "output", "device", "bus" (a CAN interface), "node" (DroneCAN), "value",
    /// "configuration", or "daemon".
    std::string_view part{};
    std::string name{};
    /// The field that has changed: "cause" of an input; "state", "input", "waits_for" or, for all
    /// else, "text" of an output; "lost" of the daemon; "state" of all others.
    std::string_view field{};
    std::string was{};
    std::string now{};
    std::string text{};        ///< for people: how the part is now
    std::string_view state{};  ///< of an input its cause, of an output its state
    std::string input{};       ///< of an output: the input in control
    LogLevel level = LogLevel::warning;
    /// Stands before the name in a line, as in "device /dev/ttyUSB0". May be empty.
    std::string_view kind{};
};

/// The change as a line of a log: "output servos: in failsafe".
std::string line_of(const ToldChange& change);

}  // namespace tribus
