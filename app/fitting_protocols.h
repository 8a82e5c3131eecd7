#pragma once

#include <string>
#include <string_view>

#include "transports/links/recording.h"

namespace tribus {

/// What to say where `asked` finds no frame in a recording that has some bytes or CAN frames: the
/// protocols, with their default settings, that do find frames there.
std::string no_frame_text(const Recording& recording, std::string_view asked);

}  // namespace tribus
