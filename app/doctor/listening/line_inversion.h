#pragma once

#include <cstddef>
#include <optional>

#include "app/doctor/listening/line_heard.h"
#include "core/time.h"
#include "transports/codecs/protocol.h"

namespace tribus::doctor {

/// Evidence that the wire is inverted against what the port expects.
struct Inversion {
    std::optional<Duration> period;  ///< period of the frames
    /// How many of the first bytes came behind a gap. Bytes inside of frames may look like those of
    /// another protocol.
    std::size_t behind_gaps = 0;
};

/// Looks for inverted frames of the protocol in what a port with these settings received. Nothing
/// if it looks like anything else. Pure.
///
/// Any kind of port sees the idle level of an inverted line as a break, and takes the first falling
/// edge after it for a start bit. So the first byte after a silence follows from the bytes with
/// which frames begin: the SBUS header 0F becomes F8 with a framing error; 20 40 of i.Bus becomes
/// FB, or F3 with a pause of a bit between its bytes. The bytes after it depend on how the port
/// synchronises again.
std::optional<Inversion> inverted_frames(const Heard& heard, const Protocol& protocol);

/// The period of whatever comes between pauses; nothing if it is not regular. It is all that is
/// known if an adapter reports only breaks. Pure.
std::optional<Duration> period_of_breaks(const Heard& heard);

}  // namespace tribus::doctor
