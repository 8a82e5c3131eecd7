#pragma once

#include <optional>

#include "app/doctor/line_heard.h"
#include "core/time.h"

namespace tribus::doctor {

/// What speaks for a wire that is inverted against what the port expects.
struct Inversion {
    std::optional<Duration> period;  ///< of the frames
};

/// Judges what was heard without frames, with the settings of the protocol itself. Nothing where it
/// sounds like anything else. Pure.
///
/// A port sees the idle of an inverted line as a break and takes the first falling edge after it
/// for a start bit, whatever kind of port it is. So the first byte behind the silence is known to
/// the bit: SBUS's header 0F becomes F8 with a framing error; i.Bus's 20 40 becomes F3, or FB where
/// its bytes stand without a pause; 04, with which requests of the sensor bus begin, 9F. What
/// follows depends on how the port gets into step again.
std::optional<Inversion> inverted_sbus(const Heard& heard);
std::optional<Inversion> inverted_ibus(const Heard& heard);
std::optional<Inversion> inverted_sensor_bus(const Heard& heard);

/// Of what comes between pauses, whatever it is; nothing where it is not regular. An adapter that
/// tells no more than breaks leaves only this. Pure.
std::optional<Duration> period_of_breaks(const Heard& heard);

}  // namespace tribus::doctor
