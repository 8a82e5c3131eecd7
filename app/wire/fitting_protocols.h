#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "transports/recordings/recording_source.h"

namespace tribus {

/// Text for a recording in which `asked` finds no frame: names the protocols that find frames there
/// with their default settings. `given`: its bytes or CAN frames.
std::string no_frame_text(RecordingSource& recording, std::string_view asked, std::uint64_t given);

}  // namespace tribus
