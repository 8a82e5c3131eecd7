#include "app/bench/report.h"

#include <array>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/bench/requirement.h"
#include "app/bench/table.h"

namespace tribus::bench {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 6> kHeadings{{
    {"latency", "Latency, from the write of a frame to the read of its last byte"},
    {"lateness", "Lateness of an output with schedule \"grid\" against its deadline"},
    {"age", "Age of the values when they are sent, with an i.Bus receiver of 7.715 ms"},
    {"codecs", "Processor time of a codec, for one frame of all channels"},
    {"capacity", "Processor time, at a frame each 7 ms for each pipeline"},
    {"ppm", "PPM at rest: how far each pulse is from the middle of its channel"},
}};

std::string figure_text(double figure, const std::string& unit) {
    return unit == "ns" ? short_time(Duration(static_cast<std::int64_t>(figure)))
                        : fmt::format("{:.0f}", figure);
}

}  // namespace

void Report::add(std::string_view group, std::string what, Duration figure,
                 std::optional<Duration> anchor, std::string reading) {
    Measurement measurement;
    measurement.group = group;
    measurement.what = std::move(what);
    measurement.figure = static_cast<double>(figure.count());
    if (anchor) {
        measurement.anchor = static_cast<double>(anchor->count());
    }
    measurement.reading = std::move(reading);
    measurements.push_back(std::move(measurement));
}

std::string report_text(const Report& report, std::size_t columns) {
    std::vector<Row> rows;
    for (const auto& [group, heading] : kHeadings) {
        bool first = true;
        for (const Measurement& measured : report.measurements) {
            if (measured.group != group) {
                continue;
            }
            if (std::exchange(first, false)) {
                rows.push_back({.what = std::string(heading)});
            }
            rows.push_back(
                {.what = measured.what,
                 .figure = figure_text(measured.figure, measured.unit),
                 .anchor = measured.anchor ? figure_text(*measured.anchor, measured.unit) : "",
                 .ratio = measured.ratio(),
                 .reading = measured.reading});
        }
    }
    std::string text;
    for (const std::string& missing : report.missing) {
        text += fmt::format("not permitted here: {}\n", missing);
    }
    text += draw_table(rows, columns);
    for (const std::string& broken : report.broken) {
        text += broken + "\n";
    }
    return text;
}

std::string report_json(const Report& report) {
    using Json = nlohmann::ordered_json;
    Json measurements = Json::array();
    for (const Measurement& measured : report.measurements) {
        Json entry = {{"group", measured.group},
                      {"what", measured.what},
                      {"figure", measured.figure},
                      {"unit", measured.unit}};
        if (measured.anchor) {
            entry["anchor"] = *measured.anchor;
        }
        if (const auto ratio = measured.ratio()) {
            entry["ratio"] = *ratio;
        }
        entry["reading"] = measured.reading;
        measurements.push_back(std::move(entry));
    }
    const Json all = {{"missing", report.missing},
                      {"measurements", std::move(measurements)},
                      {"broken", report.broken}};
    return all.dump(2) + "\n";
}

}  // namespace tribus::bench
