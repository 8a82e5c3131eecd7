#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/doctor/line_judge.h"
#include "core/line_settings.h"
#include "core/time.h"

namespace tribus::doctor {

/// What a port made of the settings of a protocol.
struct Trial {
    LineSettings line;
    std::string refusal;  ///< a sentence; empty: it takes them
};

/// What came of opening a port.
struct Visit {
    std::vector<Trial> trials;
    std::optional<LineStory> story;
    std::string failure;  ///< why it could not be opened, or was lost; empty if neither
};

/// Opens the port as `tribus run` does, with the settings of each protocol in turn, and listens for
/// `time` in all: briefly with each, then with that in which frames were heard, or else with each
/// once more. Never writes. `says` is told what happens, for a person who waits.
Visit visit_port(const std::string& device, Duration time,
                 const std::function<void(std::string_view)>& says);

}  // namespace tribus::doctor
