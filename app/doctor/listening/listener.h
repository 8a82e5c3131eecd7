#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/doctor/listening/line_judge.h"
#include "core/line_settings.h"
#include "core/time.h"

namespace tribus::doctor {

/// The settings with which a port is listened to: those of all protocols that can be read, and
/// those that are tried too if nothing is recognised. Each once.
std::vector<LineSettings> usual_lines();
std::vector<LineSettings> further_lines();

/// Whether a port accepts the settings of a protocol.
struct Trial {
    LineSettings line;
    std::string refusal;  ///< a sentence; empty if the port accepts them
};

/// Result of opening and listening to a port.
struct Visit {
    std::vector<Trial> trials;
    std::optional<LineStory> story;
    std::string failure;  ///< why the port could not be opened or was lost; else empty
};

/// Opens the port as `tribus run` does, with the settings of each protocol in turn, and listens for
/// `time`: first briefly with each, then with the settings that gave frames. A look at all settings
/// takes 3 s. What is left is for the first settings if nothing was heard, else again for all.
/// Never writes. Passes progress messages to `says`.
Visit visit_port(const std::string& device, Duration time,
                 const std::function<void(std::string_view)>& says);

/// Opens the port with these settings and closes it again: one trial, no story. Never writes.
Visit try_port(const std::string& device, const LineSettings& line);

}  // namespace tribus::doctor
