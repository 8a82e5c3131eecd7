#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/time.h"

namespace tribus {

/// What `record_port` is to record, and where to.
struct PortRecording {
    std::string port;  ///< path of a serial device or name of a CAN interface
    std::string protocol;
    std::string baud;
    std::string file;
    bool force = false;            ///< overwrite the file if it exists
    std::optional<Duration> time;  ///< empty: until a signal
    std::uintmax_t most_bytes = 0;
};

/// Writes what arrives at a port to a file until a signal, the time or the size ends it. Prints
/// messages to standard error; returns the exit status.
int record_port(const PortRecording& recording);

}  // namespace tribus
