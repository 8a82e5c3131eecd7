#pragma once

#include <functional>
#include <iosfwd>
#include <string>

#include "app/wire/sensors/sensor_printer.h"
#include "transports/recordings/recording.h"

/// `decode` for the sensor bus, which has no channel frames but requests and replies.
namespace tribus {

/// Decodes a whole recording and prints heading, exchanges and summary. Returns the exit status:
/// kExitFailed if there are bytes but no frame.
int decode_sensor_recording(const Recording& recording, SensorPrinter& printer,
                            std::ostream& messages);

/// Decodes raw bytes as they arrive. `read` returns the next bytes, none at the end.
int decode_sensor_stream(const std::function<std::string()>& read, SensorPrinter& printer,
                         std::ostream& results);

}  // namespace tribus
