#pragma once

#include <string>
#include <string_view>

#include "transports/recordings/recording.h"

namespace tribus {

/// Text for a recording in which `asked` finds no frame: names the protocols that find frames there
/// with their default settings.
std::string no_frame_text(const Recording& recording, std::string_view asked);

}  // namespace tribus
