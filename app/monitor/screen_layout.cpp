#include "app/monitor/screen_layout.h"

#include <algorithm>
#include <array>
#include <span>

#include <fmt/format.h>

#include "core/counted.h"

namespace tribus::monitor {
namespace {

/// "3 more inputs, 18 channels below".
std::string hidden_line(std::span<const BodyRow> hidden, std::string_view where,
                        const ScreenStyle& style) {
    std::string text;
    for (std::size_t i = 0; i < hidden.size();) {
        const std::string_view noun = hidden[i].noun;
        const auto other = std::ranges::find_if(
            hidden.subspan(i), [&](const BodyRow& row) { return row.noun != noun; });
        const auto count = static_cast<std::size_t>(other - hidden.subspan(i).begin());
        i += count;
        if (!noun.empty()) {
            const std::string more(text.empty() ? "more " : "");
            text += (text.empty() ? "" : ", ") +
                    counted(count, more + std::string(noun),
                            noun == "sensor bus" ? more + "sensor buses" : std::string());
        }
    }
    screen::Line line(style);
    line.add(fmt::format("{} {} {}", style.unicode ? "…" : "...", text, where), screen::kYellow);
    return line.take();
}

}  // namespace

std::size_t ScreenLayout::last_top() const {
    const std::size_t rows = room - (has_marks() ? 1 : 0);
    return body.size() - std::min(rows, body.size());
}

ScreenLayout::Window ScreenLayout::window(std::size_t top) const {
    // The row itself takes no more room than a mark that says that it is missing.
    const std::size_t first = has_marks() && top == 1 ? 0 : std::min(top, last_top());
    Window window{.top = first, .end = first, .tells_above = has_marks() && first > 0};
    const std::size_t rows = room - (window.tells_above ? 1 : 0);
    window.tells_below = has_marks() && first + rows < body.size();
    window.end = std::min(first + rows - (window.tells_below ? 1 : 0), body.size());
    return window;
}

std::size_t ScreenLayout::top_after_page(std::size_t top, bool down) const {
    const Window now = window(top);
    if (down) {
        return std::min(std::max(now.end, now.top + 1), last_top());
    }
    const std::size_t marks = has_marks() ? 2 : 0;
    const std::size_t page = std::max<std::size_t>(room - std::min(marks, room), 1);
    return now.top - std::min(page, now.top);
}

Lines ScreenLayout::rows(std::size_t top, const ScreenStyle& style) const {
    const Window shown = window(top);
    const std::span<const BodyRow> all(body);
    Lines rows = head;
    if (shown.tells_above) {
        rows.push_back(hidden_line(all.first(shown.top), "above", style));
    }
    for (const BodyRow& row : all.subspan(shown.top, shown.end - shown.top)) {
        rows.push_back(row.text);
    }
    if (shown.tells_below) {
        rows.push_back(hidden_line(all.subspan(shown.end), "below", style));
    }
    return rows;
}

std::string ScreenLayout::keys_line(std::size_t top, const ScreenStyle& style) const {
    constexpr std::array<std::string_view, 4> kKeys{
        "up/down selects  PgUp/PgDn scrolls  p pauses  q quits",
        "up/down PgUp/PgDn  p pauses  q quits", "PgUp/PgDn  q quits", "q quits"};
    const Window shown = window(top);
    const std::string place = last_top() == 0
                                  ? std::string()
                                  : fmt::format("  {}-{} of {}", std::min(shown.top + 1, shown.end),
                                                shown.end, body.size());
    const auto* const fits = std::ranges::find_if(
        kKeys, [&](std::string_view keys) { return keys.size() + place.size() <= style.columns; });
    screen::Line line(style);
    line.add(fits == kKeys.end() ? kKeys.back() : *fits, screen::kDim);
    line.add(place, screen::kDim);
    return line.take();
}

}  // namespace tribus::monitor
