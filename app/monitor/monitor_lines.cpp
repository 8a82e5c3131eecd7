#include "app/monitor/monitor_lines.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/screen_parts.h"
#include "app/state_text/cause_text.h"

namespace tribus::monitor {
namespace {

using namespace screen;

std::string padded(std::string_view text, std::size_t width) {
    return fmt::format("{:{}} ", text, width);
}

std::string rate(const Json& item) {
    return fmt::format("{:6.1f}/s", status_fields::number(item, "rate_hz").value_or(0));
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
    // A socket may say any number; a longer time does not fit into a Duration.
    constexpr double kMostMicroseconds = 9e15;
    const double number = std::clamp(status_fields::number(object, key).value_or(0),
                                     -kMostMicroseconds, kMostMicroseconds);
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::micro>(number));
}

std::string_view colour_of(const std::string& state) {
    return state == "good" || state == "control"      ? kGreen
           : state == "frame_lost" || state == "hold" ? kYellow
                                                      : kRed;
}

std::string input_state(const Json& input) {
    const std::string state = status_fields::text(input, "state");
    if (state != "failsafe") {
        return in_words(state);
    }
    const auto since = status_fields::number(input, "state_age_us");
    return in_words(status_fields::text(input, "cause")) +
           (since ? fmt::format(" {}", short_duration(us_of(input, "state_age_us"))) : "");
}

std::string input_line(const Json& input, bool selected, bool old, const ScreenStyle& style) {
    Line line(style);
    const std::string state = status_fields::text(input, "state");
    line.add(selected ? "> " : "  ", kBold);
    line.add(padded(status_fields::text(input, "name"), kNameWidth), selected ? kBold : "");
    line.add(padded(status_fields::text(input, "protocol"), kProtocolWidth), kDim);
    line.add(padded(input_state(input), kStateWidth), old ? kDim : colour_of(state));
    line.add(rate(input));
    const auto age = status_fields::number(input, "age_us");
    line.add("  age " + (age ? short_duration(us_of(input, "age_us")) : std::string("-")));
    line.add(fmt::format("  rejected {}", sum(status_fields::field(input, "rejected"))));
    line.add("  " + status_fields::text(input, "port"), kDim);
    return line.take();
}

std::string output_state(const Json& output) {
    const std::string state = status_fields::text(output, "state");
    const std::string input = status_fields::text(output, "input");
    const std::string module = status_fields::text(output, "module");
    if (module == "silent" || module == "unreadable") {
        return in_words(state) + ", module " + module;
    }
    if (state == "control" && !input.empty()) {
        return "control of " + input;
    }
    return in_words(state);
}

std::string awaited_text(const Json& output) {
    const std::string awaited = status_fields::text(output, "waits_for");
    return awaited.empty() ? "" : "waits for " + awaited;
}

std::string output_line(const Json& output, bool selected, bool old, const ScreenStyle& style) {
    Line line(style);
    line.add(selected ? "> " : "  ", kBold);
    line.add(padded(status_fields::text(output, "name"), kNameWidth), selected ? kBold : "");
    line.add(padded(status_fields::text(output, "protocol"), kProtocolWidth), kDim);
    line.add(padded(output_state(output), kStateWidth),
             old ? kDim : colour_of(status_fields::text(output, "state")));
    if (const std::string awaited = awaited_text(output); !awaited.empty()) {
        line.add(awaited + "  ", old ? kDim : "");
    }
    line.add(rate(output));
    const Json& lateness = status_fields::field(output, "lateness");
    line.add(fmt::format("  late {} p99 {}", short_duration(us_of(lateness, "p50_us")),
                         short_duration(us_of(lateness, "p99_us"))));
    const std::uint64_t missed = status_fields::count(output, "deadline_misses");
    const std::uint64_t dropped = sum(status_fields::field(output, "dropped"));
    line.add(fmt::format("  missed {}", missed), missed == 0 ? "" : kYellow);
    line.add(fmt::format("  dropped {}", dropped), dropped == 0 ? "" : kYellow);
    for (const Json& name : status_fields::list(output, "outvoted")) {
        line.add("  outvoted: " +
                     (name.is_string() ? status_fields::shown(name.get<std::string>()) : ""),
                 kYellow);
    }
    return line.take();
}

std::string port_line(const Json& port, const ScreenStyle& style) {
    Line line(style);
    const Json& can = status_fields::field(port, "can");
    const std::string state = !status_fields::flag(port, "present") ? "GONE"
                              : can.is_object() ? in_words(status_fields::text(can, "state"))
                                                : "there";
    const bool fine = state == "there" || state == "ready";
    line.add("  " + padded(status_fields::text(port, "name"), 20));
    line.add(padded(state, 9), fine ? kGreen : kRed);
    if (can.is_object()) {
        line.add(fmt::format(
            "received {}  sent {}  errors {}  bus-offs {}", status_fields::count(can, "received"),
            status_fields::count(can, "sent"), status_fields::count(can, "error_frames"),
            status_fields::count(can, "bus_offs")));
    }
    return line.take();
}

std::string bus_line(const Json& bus, const ScreenStyle& style) {
    Line line(style);
    line.add("  " + padded(status_fields::text(bus, "name"), kNameWidth));
    line.add(padded(status_fields::text(bus, "role"), 8), kDim);
    const Json& counts = status_fields::field(bus, "counts");
    if (status_fields::text(bus, "role") == "receiver") {
        line.add(fmt::format(
            "{} sensors  replies {}  misses {}", status_fields::list(bus, "found").size(),
            status_fields::count(counts, "replies"), status_fields::count(counts, "misses")));
        for (const Json& fault : status_fields::list(bus, "faults")) {
            line.add(fmt::format("  address {}: {}", status_fields::count(fault, "address"),
                                 in_words(status_fields::text(fault, "fault"))),
                     kYellow);
        }
    } else {
        line.add(fmt::format(
            "requests {}  answered {}  late {}  stale {}", status_fields::count(counts, "requests"),
            status_fields::count(counts, "answered"), status_fields::count(counts, "late"),
            status_fields::count(counts, "stale")));
    }
    return line.take();
}

std::string value_line(const Json& value, const ScreenStyle& style) {
    Line line(style);
    const auto number = status_fields::number(value, "number");
    const bool old = status_fields::flag(value, "stale");
    line.add("  " + padded(status_fields::text(value, "name"), 28));
    line.add(number ? fmt::format("{:>10.6g} {}", *number, status_fields::text(value, "unit"))
                    : std::string("         -"),
             old ? kDim : "");
    line.add(!number ? "  never" : old ? "  stale" : "", kYellow);
    return line.take();
}

}  // namespace tribus::monitor
