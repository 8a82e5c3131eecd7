#include "app/monitor_screen.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "app/demo_screen.h"
#include "app/monitor_fields.h"
#include "core/channel_frame.h"

namespace tribus {
namespace {

using namespace screen;
using monitor::Json;

/// A daemon tells at least once in that time; figures that are older are no figures of now.
constexpr Duration kFresh = std::chrono::seconds(1);
constexpr std::size_t kNameWidth = 12;

Duration us_of(const Json& object, const char* key) {
    const double number = monitor::number(object, key).value_or(0);
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::micro>(number));
}

/// As old as the slowest part of the way here.
Duration figures_age(const MonitorView& view) {
    return view.age + us_of(view.status, "figures_age_us");
}

bool stale(const MonitorView& view) {
    return figures_age(view) > kFresh || !view.connected;
}

std::string words(std::string text) {
    std::ranges::replace(text, '_', ' ');
    return text;
}

std::string_view colour_of(const std::string& state) {
    return state == "good" || state == "control"      ? kGreen
           : state == "frame_lost" || state == "hold" ? kYellow
                                                      : kRed;
}

std::string padded(std::string_view text, std::size_t width) {
    return fmt::format("{:{}} ", text, width);
}

std::string rate(const Json& item) {
    return fmt::format("{:6.1f}/s", monitor::number(item, "rate_hz").value_or(0));
}

std::string input_state(const Json& input) {
    const std::string state = monitor::text(input, "state");
    if (state != "failsafe") {
        return words(state);
    }
    const auto since = monitor::number(input, "state_age_us");
    return words(monitor::text(input, "cause")) +
           (since ? fmt::format(" {}", short_duration(us_of(input, "state_age_us"))) : "");
}

std::uint64_t sum(const Json& counts) {
    std::uint64_t total = 0;
    for (const Json& value : counts) {
        total += value.is_number_unsigned() ? value.get<std::uint64_t>() : 0;
    }
    return total;
}

std::string input_line(const Json& input, bool selected, bool old, const ScreenStyle& style) {
    Line line(style);
    const std::string state = monitor::text(input, "state");
    line.add(selected ? "> " : "  ", kBold);
    line.add(padded(monitor::text(input, "name"), kNameWidth), selected ? kBold : "");
    line.add(padded(monitor::text(input, "protocol"), 8), kDim);
    line.add(padded(input_state(input), 22), old ? kDim : colour_of(state));
    line.add(rate(input));
    const auto age = monitor::number(input, "age_us");
    line.add("  age " + (age ? short_duration(us_of(input, "age_us")) : std::string("-")));
    line.add(fmt::format("  rejected {}", sum(monitor::field(input, "rejected"))));
    line.add("  " + monitor::text(input, "port"), kDim);
    return line.take();
}

std::string output_state(const Json& output) {
    const std::string state = monitor::text(output, "state");
    const std::string input = monitor::text(output, "input");
    if (state == "control" && !input.empty()) {
        return "control of " + input;
    }
    return words(state) + (monitor::flag(output, "forced")           ? ", wanted"
                           : monitor::flag(output, "awaits_release") ? ", waits for release"
                                                                     : "");
}

std::string output_line(const Json& output, bool selected, bool old, const ScreenStyle& style) {
    Line line(style);
    line.add(selected ? "> " : "  ", kBold);
    line.add(padded(monitor::text(output, "name"), kNameWidth), selected ? kBold : "");
    line.add(padded(monitor::text(output, "protocol"), 8), kDim);
    line.add(padded(output_state(output), 22),
             old ? kDim : colour_of(monitor::text(output, "state")));
    line.add(rate(output));
    const Json& lateness = monitor::field(output, "lateness");
    line.add(fmt::format("  late {} p99 {}", short_duration(us_of(lateness, "p50_us")),
                         short_duration(us_of(lateness, "p99_us"))));
    const std::uint64_t missed = monitor::count(output, "deadline_misses");
    const std::uint64_t dropped = sum(monitor::field(output, "dropped"));
    line.add(fmt::format("  missed {}", missed), missed == 0 ? "" : kYellow);
    line.add(fmt::format("  dropped {}", dropped), dropped == 0 ? "" : kYellow);
    for (const Json& name : monitor::list(output, "outvoted")) {
        line.add("  outvoted: " + (name.is_string() ? monitor::shown(name.get<std::string>()) : ""),
                 kYellow);
    }
    return line.take();
}

std::string port_line(const Json& port, const ScreenStyle& style) {
    Line line(style);
    const Json& can = monitor::field(port, "can");
    const std::string state = !monitor::flag(port, "present") ? "GONE"
                              : can.is_object()               ? words(monitor::text(can, "state"))
                                                              : "there";
    const bool fine = state == "there" || state == "ready";
    line.add("  " + padded(monitor::text(port, "name"), 20));
    line.add(padded(state, 9), fine ? kGreen : kRed);
    if (can.is_object()) {
        line.add(fmt::format("received {}  sent {}  errors {}  bus-offs {}",
                             monitor::count(can, "received"), monitor::count(can, "sent"),
                             monitor::count(can, "error_frames"), monitor::count(can, "bus_offs")));
    }
    return line.take();
}

std::string bus_line(const Json& bus, const ScreenStyle& style) {
    Line line(style);
    line.add("  " + padded(monitor::text(bus, "name"), kNameWidth));
    line.add(padded(monitor::text(bus, "role"), 8), kDim);
    const Json& counts = monitor::field(bus, "counts");
    if (monitor::text(bus, "role") == "receiver") {
        line.add(fmt::format("{} sensors  replies {}  misses {}",
                             monitor::list(bus, "found").size(), monitor::count(counts, "replies"),
                             monitor::count(counts, "misses")));
    } else {
        line.add(fmt::format("asked {}  answered {}  late {}  stale {}",
                             monitor::count(counts, "requests"), monitor::count(counts, "answered"),
                             monitor::count(counts, "late"), monitor::count(counts, "stale")));
    }
    return line.take();
}

std::string value_line(const Json& value, const ScreenStyle& style) {
    Line line(style);
    const auto number = monitor::number(value, "number");
    const bool old = monitor::flag(value, "stale");
    line.add("  " + padded(monitor::text(value, "name"), 28));
    line.add(number ? fmt::format("{:>10.6g} {}", *number, monitor::text(value, "unit"))
                    : std::string("         -"),
             old ? kDim : "");
    line.add(!number ? "  never" : old ? "  stale" : "", kYellow);
    return line.take();
}

using Lines = std::vector<std::string>;

std::string title(std::string_view text, const ScreenStyle& style) {
    Line line(style);
    line.add(text, kDim);
    return line.take();
}

template <class Draw>
void add_part(Lines& lines, std::string_view name, const Json& items, const ScreenStyle& style,
              Draw draw) {
    if (!items.empty()) {
        lines.push_back(title(name, style));
    }
    for (const Json& item : items) {
        lines.push_back(draw(item));
    }
}

/// Above all: whether what stands below can be believed.
std::string trust_line(const MonitorView& view, const ScreenStyle& style) {
    Line line(style);
    if (view.status.is_null()) {
        line.add(view.notice.empty() ? "waiting for the daemon" : view.notice, kYellow);
    } else if (view.paused) {
        line.add(fmt::format("PAUSED; this is what was {} ago", short_duration(figures_age(view))),
                 kYellow);
    } else if (!view.connected) {
        line.add(fmt::format("{}; this is what was {} ago", view.notice,
                             short_duration(figures_age(view))),
                 kRed);
    } else if (view.age > kFresh) {
        line.add(fmt::format("THE DAEMON DOES NOT ANSWER; this is what was {} ago",
                             short_duration(figures_age(view))),
                 kRed);
    } else if (stale(view)) {
        line.add(fmt::format("THE DATA THREAD STANDS STILL; this is what was {} ago",
                             short_duration(figures_age(view))),
                 kRed);
    } else {
        line.add(fmt::format("live, {} old", short_duration(figures_age(view))), kGreen);
        const Json& missing = monitor::list(view.status, "missing_realtime");
        line.add(missing.empty() ? ""
                                 : fmt::format("  {} things missing for real time; see the log",
                                               missing.size()),
                 kYellow);
    }
    return line.take();
}

std::string heading(const MonitorView& view, const ScreenStyle& style) {
    Line line(style);
    line.add("tribus ", kBold);
    line.add(monitor::text(view.status, "name"), kBold);
    line.add("  up " + short_duration(us_of(view.status, "uptime_us")));
    if (monitor::number(view.status, "trial_left_us")) {
        line.add("  on trial, " + short_duration(us_of(view.status, "trial_left_us")) + " left",
                 kYellow);
    }
    line.add("  " + monitor::text(view.status, "file"), kDim);
    return line.take();
}

/// What the bars show: an input alone, or an output beside the input that feeds it.
struct Compared {
    const Json* before = nullptr;
    const Json* after = nullptr;
};

Compared compared(const MonitorView& view) {
    const Json& inputs = monitor::list(view.status, "inputs");
    const Json& outputs = monitor::list(view.status, "outputs");
    if (view.selected < inputs.size()) {
        return {&inputs[view.selected], nullptr};
    }
    const std::size_t index = view.selected - inputs.size();
    if (index >= outputs.size()) {
        return {};
    }
    const Json& output = outputs[index];
    std::string wanted = monitor::text(output, "input");
    const Json& own = monitor::list(output, "inputs");
    if (wanted.empty() && !own.empty() && own.front().is_string()) {
        wanted = own.front().get<std::string>();
    }
    for (const Json& input : inputs) {
        if (monitor::text(input, "name") == wanted) {
            return {&input, &output};
        }
    }
    return {nullptr, &output};
}

std::optional<double> channel_of(const Json* item, std::size_t channel) {
    if (item == nullptr) {
        return std::nullopt;
    }
    const Json& channels = monitor::list(*item, "channels");
    const bool there = channel < channels.size() && channels[channel].is_number();
    return there ? std::optional(channels[channel].get<double>()) : std::nullopt;
}

std::string item_title(const Json* item) {
    return item == nullptr ? "" : monitor::text(*item, "name");
}

void add_channels(Lines& lines, const MonitorView& view, const ScreenStyle& style) {
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
    lines.push_back(title(
        both ? fmt::format("CHANNELS {:{}}{}", item_title(before), width + kGap, item_title(after))
             : "CHANNELS " + item_title(single),
        style));
    std::size_t count = 0;
    for (const Json* item : {before, after}) {
        count = std::max(count, item == nullptr ? 0 : monitor::list(*item, "channels").size());
    }
    for (std::size_t channel = 0; channel < std::min(count, kChannelCount); ++channel) {
        Line line(style);
        line.add(fmt::format("{:2}  ", channel + 1), kDim);
        for (const Json* item : both ? std::vector{before, after} : std::vector{single}) {
            const auto pulse = channel_of(item, channel);
            line.add(pulse_number(pulse));
            line.add(bar(pulse, width, style.unicode),
                     stale(view) ? kDim : colour_of(monitor::text(*item, "state")));
            line.add(std::string(kGap, ' '));
        }
        lines.push_back(line.take());
    }
}

Lines items(const MonitorView& view, const ScreenStyle& style) {
    Lines lines;
    std::size_t index = 0;
    const bool old = stale(view);
    add_part(lines, "INPUTS", monitor::list(view.status, "inputs"), style, [&](const Json& item) {
        return input_line(item, index++ == view.selected, old, style);
    });
    add_part(lines, "OUTPUTS", monitor::list(view.status, "outputs"), style, [&](const Json& item) {
        return output_line(item, index++ == view.selected, old, style);
    });
    return lines;
}

Lines surroundings(const MonitorView& view, const ScreenStyle& style) {
    Lines lines;
    add_part(lines, "PORTS", monitor::list(view.status, "ports"), style,
             [&](const Json& item) { return port_line(item, style); });
    add_part(lines, "SENSOR BUSES", monitor::list(view.status, "sensor_buses"), style,
             [&](const Json& item) { return bus_line(item, style); });
    add_part(lines, "VALUES", monitor::list(view.status, "values"), style,
             [&](const Json& item) { return value_line(item, style); });
    return lines;
}

}  // namespace

std::size_t selectable(const Json& status) {
    return monitor::list(status, "inputs").size() + monitor::list(status, "outputs").size();
}

std::string draw_monitor(const MonitorView& view, const ScreenStyle& style) {
    Lines lines{heading(view, style), trust_line(view, style)};
    for (Lines part : {items(view, style),
                       [&] {
                           Lines channels;
                           add_channels(channels, view, style);
                           return channels;
                       }(),
                       surroundings(view, style)}) {
        lines.insert(lines.end(), part.begin(), part.end());
    }
    // The last row has the keys, and none is written behind it: a line end there would scroll.
    const std::size_t rows = std::max<std::size_t>(style.rows, 3);
    lines.resize(std::min(lines.size(), rows - 1));
    std::string screen = "\x1b[H";
    for (const std::string& line : lines) {
        screen += line;
        screen += kEraseRest;
    }
    Line keys(style);
    keys.add("up/down selects  p pauses  q quits", kDim);
    return screen + keys.take() + "\x1b[K\x1b[J";
}

std::string monitor_line(const MonitorView& view) {
    if (view.status.is_null() || !view.connected) {
        return view.notice.empty() ? "waiting for the daemon" : view.notice;
    }
    std::string text = monitor::text(view.status, "name");
    if (stale(view)) {
        text += fmt::format("  STANDS STILL since {}", short_duration(figures_age(view)));
    }
    for (const Json& input : monitor::list(view.status, "inputs")) {
        text += fmt::format("  {} {} {:.1f}/s", monitor::text(input, "name"), input_state(input),
                            monitor::number(input, "rate_hz").value_or(0));
    }
    for (const Json& output : monitor::list(view.status, "outputs")) {
        text += fmt::format("  {} {} {:.1f}/s late {}", monitor::text(output, "name"),
                            output_state(output), monitor::number(output, "rate_hz").value_or(0),
                            short_duration(us_of(monitor::field(output, "lateness"), "p99_us")));
    }
    return text;
}

}  // namespace tribus
