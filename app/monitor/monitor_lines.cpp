#include "app/monitor/monitor_lines.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/screen_parts.h"

namespace tribus::monitor {
namespace {

using namespace screen;

constexpr std::size_t kNameWidth = 12;

std::string words(std::string text) {
    std::ranges::replace(text, '_', ' ');
    return text;
}

std::string padded(std::string_view text, std::size_t width) {
    return fmt::format("{:{}} ", text, width);
}

std::string rate(const Json& item) {
    return fmt::format("{:6.1f}/s", monitor::number(item, "rate_hz").value_or(0));
}

std::uint64_t sum(const Json& counts) {
    std::uint64_t total = 0;
    for (const Json& value : counts) {
        total += value.is_number_unsigned() ? value.get<std::uint64_t>() : 0;
    }
    return total;
}

}  // namespace

Duration us_of(const Json& object, const char* key) {
    const double number = monitor::number(object, key).value_or(0);
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::micro>(number));
}

std::string_view colour_of(const std::string& state) {
    return state == "good" || state == "control"      ? kGreen
           : state == "frame_lost" || state == "hold" ? kYellow
                                                      : kRed;
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
    return words(state) + (monitor::flag(output, "forced")           ? ", forced"
                           : monitor::flag(output, "awaits_release") ? ", awaits release"
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
        line.add(fmt::format("requests {}  answered {}  late {}  stale {}",
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

}  // namespace tribus::monitor
