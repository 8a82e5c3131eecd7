#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "app/cli/screen_parts.h"
#include "core/time.h"

/// The screen of `tribus monitor`. Pure.
namespace tribus {

// The destructor of nlohmann::json is declared noexcept but could throw.
// NOLINTNEXTLINE(bugprone-exception-escape)
struct MonitorView {
    /// The latest status; null before the first.
    nlohmann::json status;
    Duration age{};  ///< since it was received
    bool connected = true;
    bool paused = false;
    /// A sentence about the connection; may be empty.
    std::string notice;
    /// Index among the inputs and outputs together. Empty: the first output, shown with the
    /// channels of its input beside its own.
    std::optional<std::size_t> selected;
    /// Index of the first visible line of the scrolling part.
    std::size_t top = 0;
};

/// Number of inputs and outputs.
std::size_t selectable(const nlohmann::json& status);

/// Index of the selected one, whether the user chose it or not.
std::size_t selected_item(const MonitorView& view);

/// New `top` after one page up (`pages` < 0) or down.
std::size_t top_after_pages(const MonitorView& view, const ScreenStyle& style, int pages);
/// `top` that brings the selected line and its channels onto the screen.
std::size_t top_that_shows_selected(const MonitorView& view, const ScreenStyle& style);

/// The whole screen: at most `rows` lines, but at least three, of at most `columns` characters. The
/// last line says which lines of how many are visible. Each line ends with "erase to end of line".
std::string draw_monitor(const MonitorView& view, const ScreenStyle& style);

/// One line, for use without a terminal.
std::string monitor_line(const MonitorView& view);

}  // namespace tribus
