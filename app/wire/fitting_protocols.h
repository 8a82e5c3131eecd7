#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "transports/recordings/recording_source.h"

namespace tribus {

/// A sentence about frames of a recording that no protocol reads: those of FrSky's SBUS with 24
/// channels. Empty if there are none.
std::string unread_frames_text(RecordingSource& recording);

/// Text for a recording in which `asked` finds no frame: names the protocols that find frames there
/// with their default settings. `given`: its bytes or CAN frames.
std::string no_frame_text(RecordingSource& recording, std::string_view asked, std::uint64_t given);

}  // namespace tribus
