#pragma once

#include <functional>
#include <iosfwd>
#include <string>

#include "app/sensor_printer.h"
#include "transports/links/recording.h"

/// `decode` of the sensor bus: it has no frames of channels, but questions and answers.
namespace tribus {

inline constexpr const char* kSensorProtocol = "ibus-sensor";

/// Explains a whole recording and prints heading, exchanges and summary; returns the exit status: a
/// failure where there are bytes, but no frame.
int decode_sensor_recording(const Recording& recording, SensorPrinter& printer, std::ostream& talk);

/// Explains raw bytes as they come; `read` returns the next ones, none at the end.
int decode_sensor_stream(const std::function<std::string()>& read, SensorPrinter& printer,
                         std::ostream& results);

}  // namespace tribus
