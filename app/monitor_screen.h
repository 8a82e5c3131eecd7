#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
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
    /// Among the inputs and outputs, counted through; nothing chosen: the first output, whose
    /// channels stand beside those of its input.
    std::optional<std::size_t> selected;
    /// The first line of what scrolls.
    std::size_t top = 0;
};

/// How many inputs and outputs can be selected.
std::size_t selectable(const nlohmann::json& status);

/// The one that is selected, chosen or not.
std::size_t selected_item(const MonitorView& view);

/// `top` after one page up (`pages` below 0) or down.
std::size_t top_after_pages(const MonitorView& view, const ScreenStyle& style, int pages);
/// `top` with the selected one on the screen, its channels behind it.
std::size_t top_that_shows_selected(const MonitorView& view, const ScreenStyle& style);

/// The whole screen, at most `rows` lines, or three, of at most `columns` characters; the last one
/// says which lines of how many are shown. Every line ends with "erase to end of line".
std::string draw_monitor(const MonitorView& view, const ScreenStyle& style);

/// One line for where there is no terminal.
std::string monitor_line(const MonitorView& view);

}  // namespace tribus
