#include "app/bench/measurements.h"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/distribution.h"
#include "core/quantity.h"

namespace tribus::bench {
namespace {

/// Times have at most three digits: "0.85us", "42us", "3.51ms".
std::string figure_text(double figure, std::string_view unit) {
    constexpr double kThousand = 1000;
    const double us = figure / kThousand;
    return unit != "ns" ? fmt::format("{:.0f}", figure)
           : us < 999.5 ? fmt::format("{:.3g}us", us)
                        : fmt::format("{:.3g}ms", us / kThousand);
}

}  // namespace

tl::expected<Requirement, std::string> parse_requirement(std::string_view text) {
    constexpr std::string_view kAdded = "added-";
    const bool added = text.starts_with(kAdded);
    const std::string_view name = text.substr(added ? kAdded.size() : 0);
    const std::string_view what = name.substr(0, name.find('='));
    const auto most = parse_duration(name.substr(std::min(what.size() + 1, name.size())));
    if (!most || (what != "p50" && what != "p90" && what != "p99")) {
        return tl::unexpected(fmt::format(
            "--require {}: allowed: p50, p90 or p99, with or without added- in front, then = and a "
            "time in us, ms or s, such as p99=200us or added-p50=20us",
            text));
    }
    return Requirement{std::string(text), std::string(what), added, *most};
}

void Report::add(std::string_view group, std::string what, Duration figure, Duration anchor,
                 Duration anchor_again, std::string_view peer) {
    const double ratio = ratio_of(figure, anchor);
    const double noise = noise_allowance(anchor, anchor_again);
    const char* const how = ratio <= 0.9           ? "better than"
                            : ratio <= 1.1 * noise ? "as good as"
                            : ratio <= 1.5 * noise ? "nearly as good as"
                                                   : "worse than";
    measurements.push_back({.group = std::string(group),
                            .what = std::move(what),
                            .figure = static_cast<double>(figure.count()),
                            .anchor = static_cast<double>(anchor.count()),
                            .reading = fmt::format("{} {}", how, peer)});
}

void Report::judge(const Requirement& requirement) {
    for (const Measurement& latency : measurements) {
        if (latency.group != "latency" || latency.what != requirement.what) {
            continue;
        }
        const double measured =
            latency.figure - (requirement.added ? latency.anchor.value_or(0) : 0);
        if (measured > static_cast<double>(requirement.most.count())) {
            broken.push_back(fmt::format("{} does not hold: the {}latency's {} was {}",
                                         requirement.text, requirement.added ? "added " : "",
                                         requirement.what, figure_text(measured, "ns")));
        }
    }
}

std::string report_text(const Report& report) {
    const std::map<std::string_view, std::string_view> headings{
        {"latency", "Latency, from the write of a frame to the read of its last byte"},
        {"cpu", "Processor time of the thread that carries a frame each 7 ms"},
        {"lateness", "Lateness of an output with schedule \"grid\" against its deadline"}};
    std::string text;
    for (const std::string& missing : report.missing) {
        text += fmt::format("not permitted here: {}\n", missing);
    }
    constexpr const char* kRow = "{:<20}{:>9} {:>9} {:>6}  {}\n";
    text += fmt::format(kRow, "what", "figure", "beside", "ratio", "reading");
    std::string_view group;
    for (const Measurement& row : report.measurements) {
        text += row.group == group ? "" : fmt::format("\n{}\n", headings.at(row.group));
        group = row.group;
        text += fmt::format(kRow, row.what, figure_text(row.figure, row.unit),
                            row.anchor ? figure_text(*row.anchor, row.unit) : "",
                            row.anchor ? fmt::format("{:.2f}", row.figure / *row.anchor) : "",
                            row.reading);
    }
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
            entry["ratio"] = measured.figure / *measured.anchor;
        }
        entry["reading"] = measured.reading;
        measurements.push_back(std::move(entry));
    }
    const Json all = {
        {"missing", report.missing}, {"measurements", measurements}, {"broken", report.broken}};
    return all.dump(2) + "\n";
}

}  // namespace tribus::bench
