#pragma once

#include <cstdint>

namespace tribus {

/// Outcome of writing one frame, or one snapshot of CAN frames.
enum class WriteStatus : std::uint8_t {
    written,      ///< passed to the kernel, whose queue had no bytes of this sender
    busy,         ///< not written, or not completely: dropped, a newer frame follows
    unavailable,  ///< the line accepts nothing now (a bus is down or in bus-off): dropped; it may
                  ///< return
    lost,         ///< the device is gone; the link stays lost until it is opened again
};

}  // namespace tribus
