#include "app/monitor/monitor_screen.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/screen_parts.h"
#include "app/client/status_fields.h"
#include "app/monitor/monitor_lines.h"
#include "app/monitor/screen_layout.h"
#include "core/channel_frame.h"
#include "core/counted.h"

namespace tribus {
namespace {

using namespace screen;
using namespace monitor;

/// A daemon sends at least once in this time; older figures are out of date.
constexpr Duration kFresh = std::chrono::seconds(1);

/// Age of the figures: their age in the daemon and the time since they came.
Duration figures_age(const MonitorView& view) {
    return view.age + us_of(view.status, "figures_age_us");
}

bool stale(const MonitorView& view) {
    return figures_age(view) > kFresh || !view.connected;
}

std::string title(std::string_view text, const ScreenStyle& style) {
    Line line(style);
    line.add(text, kDim);
    return line.take();
}

/// A list of the status with its title, such as INPUTS, and the noun for one of it.
struct PartName {
    std::string_view title;
    std::string_view noun;
};

template <class Draw>
void add_part(Body& body, PartName name, const Json& items, const ScreenStyle& style, Draw draw) {
    if (!items.empty()) {
        body.push_back({title(name.title, style)});
    }
    for (const Json& item : items) {
        body.push_back({draw(item), name.noun});
    }
}

/// Breaks lines at blanks, so that a narrow screen shows all text.
Lines wrapped(std::string_view text, std::string_view colour, const ScreenStyle& style) {
    const std::size_t columns = std::max<std::size_t>(style.columns, 1);
    Lines lines;
    while (!text.empty()) {
        std::size_t end = text.size();
        if (end > columns) {
            const std::size_t blank = text.rfind(' ', columns);
            end = blank == std::string_view::npos || blank == 0 ? columns : blank;
        }
        Line line(style);
        line.add(text.substr(0, end), colour);
        lines.push_back(line.take());
        text.remove_prefix(std::min(text.find_first_not_of(' ', end), text.size()));
    }
    return lines;
}

/// First lines of the screen: whether the figures below are current.
Lines trust_lines(const MonitorView& view, const ScreenStyle& style) {
    const std::string then = "; the figures are from " + short_duration(figures_age(view)) + " ago";
    if (view.status.is_null()) {
        return wrapped(view.notice.empty() ? "waiting for the daemon" : view.notice, kYellow,
                       style);
    }
    if (view.paused) {
        return wrapped("PAUSED" + then, kYellow, style);
    }
    if (!view.connected) {
        return wrapped(view.notice + then, kRed, style);
    }
    if (view.age > kFresh) {
        return wrapped("THE DAEMON DOES NOT ANSWER" + then, kRed, style);
    }
    if (stale(view)) {
        return wrapped("THE DATA THREAD STANDS STILL" + then, kRed, style);
    }
    Line line(style);
    line.add(fmt::format("live, {} old", short_duration(figures_age(view))), kGreen);
    const std::size_t missing = status_fields::list(view.status, "missing_realtime").size();
    line.add(missing == 0 ? ""
                          : fmt::format("  {} missing for real time; see the log",
                                        counted(missing, "thing")),
             kYellow);
    return {line.take()};
}

std::string heading(const MonitorView& view, const ScreenStyle& style) {
    Line line(style);
    line.add("tribus ", kBold);
    line.add(status_fields::text(view.status, "name"), kBold);
    line.add("  up " + short_duration(us_of(view.status, "uptime_us")));
    if (status_fields::number(view.status, "trial_left_us")) {
        line.add("  on trial, " + short_duration(us_of(view.status, "trial_left_us")) + " left",
                 kYellow);
    }
    line.add("  " + status_fields::text(view.status, "file"), kDim);
    return line.take();
}

/// What the bars show: an input alone, or an output beside the input that controls it.
struct Compared {
    const Json* before = nullptr;
    const Json* after = nullptr;
};

Compared compared(const MonitorView& view) {
    const Json& inputs = status_fields::list(view.status, "inputs");
    const Json& outputs = status_fields::list(view.status, "outputs");
    const std::size_t selected = selected_item(view);
    if (selected < inputs.size()) {
        return {&inputs[selected], nullptr};
    }
    const std::size_t index = selected - inputs.size();
    if (index >= outputs.size()) {
        return {};
    }
    const Json& output = outputs[index];
    std::string wanted = status_fields::text(output, "input");
    const Json& own = status_fields::list(output, "inputs");
    if (wanted.empty() && !own.empty() && own.front().is_string()) {
        wanted = own.front().get<std::string>();
    }
    for (const Json& input : inputs) {
        if (status_fields::text(input, "name") == wanted) {
            return {&input, &output};
        }
    }
    return {nullptr, &output};
}

std::optional<double> channel_of(const Json* item, std::size_t channel) {
    if (item == nullptr) {
        return std::nullopt;
    }
    const Json& channels = status_fields::list(*item, "channels");
    const bool there = channel < channels.size() && channels[channel].is_number();
    return there ? std::optional(channels[channel].get<double>()) : std::nullopt;
}

std::string item_title(const Json* item) {
    return item == nullptr ? "" : status_fields::text(*item, "name");
}

void add_channels(Body& body, const MonitorView& view, const ScreenStyle& style) {
    constexpr std::size_t kLabelWidth = 4;
    constexpr std::size_t kGap = 2;
    constexpr std::size_t kLeastBar = 10;
    const auto [before, after] = compared(view);
    if (before == nullptr && after == nullptr) {
        return;
    }
    const std::size_t numbers = kLabelWidth + 2 * kPulseNumberWidth + kGap;
    const bool both =
        before != nullptr && after != nullptr && style.columns > numbers + 2 * kLeastBar;
    const Json* single = after != nullptr ? after : before;
    const std::size_t room = style.columns - std::min(style.columns, both ? numbers : numbers / 2);
    const std::size_t width = both ? room / 2 : std::max<std::size_t>(room, 4) - 1;
    body.push_back({title(
        both ? fmt::format("CHANNELS {:{}}{}", item_title(before), width + kGap, item_title(after))
             : "CHANNELS " + item_title(single),
        style)});
    Line ends(style);
    ends.add(std::string(kLabelWidth, ' '));
    for (int bars = 0; bars < (both ? 2 : 1); ++bars) {
        ends.add(std::string(kPulseNumberWidth, ' ') + bar_scale(width) + std::string(kGap, ' '),
                 kDim);
    }
    body.push_back({ends.take()});
    std::size_t count = 0;
    for (const Json* item : {before, after}) {
        count =
            std::max(count, item == nullptr ? 0 : status_fields::list(*item, "channels").size());
    }
    for (std::size_t channel = 0; channel < std::min(count, kChannelCount); ++channel) {
        Line line(style);
        line.add(fmt::format("{:2}  ", channel + 1), kDim);
        for (const Json* item : both ? std::vector{before, after} : std::vector{single}) {
            const auto pulse = channel_of(item, channel);
            line.add(pulse_number(pulse));
            line.add(bar(pulse, width, style.unicode),
                     stale(view) ? kDim : colour_of(status_fields::text(*item, "state")));
            line.add(std::string(kGap, ' '));
        }
        body.push_back({line.take(), "channel"});
    }
}

void add_items(Body& body, const MonitorView& view, const ScreenStyle& style) {
    std::size_t index = 0;
    const std::size_t selected = selected_item(view);
    const bool old = stale(view);
    add_part(body, {"INPUTS", "input"}, status_fields::list(view.status, "inputs"), style,
             [&](const Json& item) { return input_line(item, index++ == selected, old, style); });
    add_part(body, {"OUTPUTS", "output"}, status_fields::list(view.status, "outputs"), style,
             [&](const Json& item) { return output_line(item, index++ == selected, old, style); });
}

/// Tells what the selected output waits for, where its own line cuts that.
void add_awaited(Body& body, const MonitorView& view, const ScreenStyle& style) {
    constexpr std::size_t kBefore = 2 + kNameWidth + kProtocolWidth + kStateWidth;
    const Json* output = compared(view).after;
    const std::string awaited = output == nullptr ? "" : awaited_text(*output);
    if (kBefore + awaited.size() <= style.columns) {
        return;
    }
    for (std::string& line : wrapped(awaited, stale(view) ? kDim : "", style)) {
        body.push_back({std::move(line)});
    }
}

void add_surroundings(Body& body, const MonitorView& view, const ScreenStyle& style) {
    add_part(body, {"PORTS", "port"}, status_fields::list(view.status, "ports"), style,
             [&](const Json& item) { return port_line(item, style); });
    add_part(body, {"SENSOR BUSES", "sensor bus"}, status_fields::list(view.status, "sensor_buses"),
             style, [&](const Json& item) { return bus_line(item, style); });
    add_part(body, {"VALUES", "value"}, status_fields::list(view.status, "values"), style,
             [&](const Json& item) { return value_line(item, style); });
}

ScreenLayout layout_of(const MonitorView& view, const ScreenStyle& style) {
    // The last row shows the keys.
    const std::size_t rows = std::max<std::size_t>(style.rows, 3) - 1;
    ScreenLayout layout;
    layout.head = {heading(view, style)};
    const Lines trust = trust_lines(view, style);
    layout.head.insert(layout.head.end(), trust.begin(), trust.end());
    if (layout.head.size() > rows) {
        layout.head.resize(rows);
        layout.head.back() = cut_mark(style);
    }
    layout.room = rows - layout.head.size();
    add_items(layout.body, view, style);
    add_awaited(layout.body, view, style);
    add_channels(layout.body, view, style);
    add_surroundings(layout.body, view, style);
    return layout;
}

}  // namespace

std::size_t selectable(const Json& status) {
    return status_fields::list(status, "inputs").size() +
           status_fields::list(status, "outputs").size();
}

std::size_t selected_item(const MonitorView& view) {
    const bool outputs = !status_fields::list(view.status, "outputs").empty();
    return view.selected.value_or(outputs ? status_fields::list(view.status, "inputs").size() : 0);
}

std::size_t top_after_pages(const MonitorView& view, const ScreenStyle& style, int pages) {
    return layout_of(view, style).top_after_page(view.top, pages > 0);
}

std::size_t top_that_shows_selected(const MonitorView& view, const ScreenStyle& style) {
    const ScreenLayout layout = layout_of(view, style);
    const std::size_t item = selected_item(view);
    const std::size_t titles = item < status_fields::list(view.status, "inputs").size() ? 1 : 2;
    const std::size_t line = item + titles;
    return line < layout.window(0).end ? 0 : std::min(line, layout.last_top());
}

std::string draw_monitor(const MonitorView& view, const ScreenStyle& style) {
    const ScreenLayout layout = layout_of(view, style);
    std::string screen = "\x1b[H";
    for (const std::string& row : layout.rows(view.top, style)) {
        screen += row;
        screen += kEraseRest;
    }
    // No line feed after the last row: it would scroll.
    return screen + layout.keys_line(view.top, style) + "\x1b[K\x1b[J";
}

std::string monitor_line(const MonitorView& view) {
    if (view.status.is_null() || !view.connected) {
        return view.notice.empty() ? "waiting for the daemon" : view.notice;
    }
    std::string text = status_fields::text(view.status, "name");
    if (stale(view)) {
        text += fmt::format("  STANDS STILL since {}", short_duration(figures_age(view)));
    }
    for (const Json& input : status_fields::list(view.status, "inputs")) {
        text +=
            fmt::format("  {} {} {:.1f}/s", status_fields::text(input, "name"), input_state(input),
                        status_fields::number(input, "rate_hz").value_or(0));
    }
    for (const Json& output : status_fields::list(view.status, "outputs")) {
        text +=
            fmt::format("  {} {}{}{} {:.1f}/s late {}", status_fields::text(output, "name"),
                        output_state(output), awaited_text(output).empty() ? "" : ", ",
                        awaited_text(output), status_fields::number(output, "rate_hz").value_or(0),
                        short_duration(us_of(status_fields::field(output, "lateness"), "p99_us")));
    }
    return text;
}

}  // namespace tribus
