#pragma once

#include <cstdint>

namespace tribus {

/// State of a CAN interface, as a sender sees it.
enum class CanBusState : std::uint8_t {
    ready,
    warning,  ///< the controller counts many errors
    passive,  ///< still more errors; it can send if another node acknowledges
    stalled,  ///< a frame has been waiting too long: no node acknowledges, or the bus is full
    bus_off,  ///< the controller has left the bus
    down,     ///< the interface is down
};

}  // namespace tribus
