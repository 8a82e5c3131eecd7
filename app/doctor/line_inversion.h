#pragma once

#include <optional>

#include "app/doctor/line_heard.h"
#include "core/time.h"

namespace tribus::doctor {

/// Evidence that the wire is inverted against what the port expects.
struct Inversion {
    std::optional<Duration> period;  ///< period of the frames
};

/// Looks for inverted frames in what a port with the settings of that protocol received. Nothing if
/// it looks like anything else. Pure.
///
/// Any kind of port sees the idle level of an inverted line as a break, and takes the first falling
/// edge after it for a start bit. So the first byte after a silence is known: the SBUS header 0F
/// becomes F8 with a framing error; 20 40 of i.Bus becomes F3, or FB without a pause between its
/// bytes; 04, the first byte of a sensor bus request, becomes 9F. The bytes after it depend on how
/// the port synchronises again.
std::optional<Inversion> inverted_sbus(const Heard& heard);
std::optional<Inversion> inverted_ibus(const Heard& heard);
std::optional<Inversion> inverted_sensor_bus(const Heard& heard);

/// The period of whatever comes between pauses; nothing if it is not regular. It is all that is
/// known if an adapter reports only breaks. Pure.
std::optional<Duration> period_of_breaks(const Heard& heard);

}  // namespace tribus::doctor
