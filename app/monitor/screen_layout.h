#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "app/cli/screen_parts.h"

/// What of the monitor fits onto a screen. Pure.
namespace tribus::monitor {

using Lines = std::vector<std::string>;

/// A row of the part that scrolls.
struct BodyRow {
    std::string text;
    /// What it shows, to count what is out of sight: "input". Empty for a title.
    std::string_view noun = {};
};
using Body = std::vector<BodyRow>;

/// The rows of the screen: a fixed head, a body that scrolls, and a row about the keys.
struct ScreenLayout {
    Lines head;
    Body body;
    std::size_t room = 0;  ///< rows for the body

    /// The rows of the body that are in sight.
    struct Window {
        std::size_t top = 0;
        std::size_t end = 0;
        /// A row says what is out of sight on that side.
        bool tells_above = false;
        bool tells_below = false;
    };
    Window window(std::size_t top) const;
    /// With this `top` the last row of the body is in sight.
    std::size_t last_top() const;
    std::size_t top_after_page(std::size_t top, bool down) const;

    /// Head and body, with the rows that say what is out of sight: "3 more inputs below".
    Lines rows(std::size_t top, const ScreenStyle& style) const;
    /// As much about the keys as fits beside the place in the body: "q quits  1-21 of 45".
    std::string keys_line(std::size_t top, const ScreenStyle& style) const;

  private:
    /// On a screen with less room all rows are needed for the body itself.
    bool has_marks() const { return room >= 4 && body.size() > room; }
};

}  // namespace tribus::monitor
