#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/time.h"

namespace tribus {

struct PortRecording {
    std::string port;  ///< path of a serial device, or CAN interface
    std::string protocol;
    std::string baud;
    std::string file;
    bool force = false;            ///< the file may be there already
    std::optional<Duration> time;  ///< absent: until a signal
    std::uintmax_t most_bytes = 0;
};

/// Writes what arrives at a port to a file until a signal comes, or the time or the size is
/// reached. Talks to standard error; returns an exit status.
int record_port(const PortRecording& recording);

}  // namespace tribus
