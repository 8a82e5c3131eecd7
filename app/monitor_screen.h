#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

#include "app/screen_parts.h"
#include "core/time.h"

/// How `tribus monitor` shows a daemon. Pure: figures in, text out.
namespace tribus {

// nlohmann's destructor is said to throw nothing, and could.
// NOLINTNEXTLINE(bugprone-exception-escape)
struct MonitorView {
    /// The latest that the daemon told; null before the first.
    nlohmann::json status;
    Duration age{};  ///< since it came
    bool connected = true;
    bool paused = false;
    /// A sentence about the connection; may be empty.
    std::string notice;
    /// Among the inputs and outputs, counted through.
    std::size_t selected = 0;
};

/// How many inputs and outputs can be selected.
std::size_t selectable(const nlohmann::json& status);

/// The whole screen, at most `rows` lines, or three, of at most `columns` characters; what does not
/// fit is left out, the least important first. Every line ends with "erase to end of line".
std::string draw_monitor(const MonitorView& view, const ScreenStyle& style);

/// One line for where there is no terminal.
std::string monitor_line(const MonitorView& view);

}  // namespace tribus
