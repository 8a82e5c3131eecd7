#include "app/status/histograms.h"

#include <chrono>
#include <cstddef>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/cli/object_text.h"
#include "config/schema/schema.h"
#include "config/show/fields_json.h"

namespace tribus {
namespace {

using HistogramJson = nlohmann::ordered_json;

HistogramJson microseconds_json(Duration duration) {
    return number_json(std::chrono::duration<double, std::micro>(duration).count());
}

/// Counts up to the last that is not zero.
HistogramJson reading_json(const HistogramReading& reading) {
    std::size_t used = reading.counts.size();
    while (used > 0 && reading.counts[used - 1] == 0) {
        --used;
    }
    HistogramJson counts = HistogramJson::array();
    for (std::size_t bucket = 0; bucket < used; ++bucket) {
        counts.push_back(reading.counts[bucket]);
    }
    return {{"counts", std::move(counts)}, {"max_us", microseconds_json(reading.worst)}};
}

HistogramJson part_json(const PartHistograms& part) {
    HistogramJson json;
    json["name"] = part.name;
    for (const TimeHistogram& histogram : part.histograms) {
        json[std::string(histogram.what)] = {{"last_minute", reading_json(histogram.last_minute)},
                                             {"since_start", reading_json(histogram.since_start)}};
    }
    return json;
}

TimeHistogram histogram_read(std::string_view what, const Histogram& histogram, Instant now) {
    return {.what = what,
            .last_minute = histogram.last_minute(now),
            .since_start = histogram.since_start()};
}

}  // namespace

HistogramsReport histograms_of(const Appliance& appliance, Instant now) {
    const Configuration& configuration = appliance.configuration();
    HistogramsReport report{.now = now, .inputs = {}, .outputs = {}};
    for (std::size_t i = 0; i < configuration.inputs.size(); ++i) {
        report.inputs.push_back(
            {.name = configuration.inputs[i].name,
             .histograms = {histogram_read("frame_age", appliance.input_timing(i).age(), now)}});
    }
    for (std::size_t i = 0; i < configuration.outputs.size(); ++i) {
        const OutputTiming& timing = appliance.output_timing(i);
        report.outputs.push_back(
            {.name = configuration.outputs[i].name,
             .histograms = {histogram_read("lateness", timing.lateness(), now),
                            histogram_read("latency", timing.latency(), now)}});
    }
    return report;
}

std::string histograms_json(const HistogramsReport& report) {
    ObjectText text;
    text.add("type", "histograms");
    text.add("version", 1);
    text.add("t_us",
             std::chrono::duration_cast<std::chrono::microseconds>(report.now.time_since_epoch())
                 .count());
    text.add_list("starts_us", kHistogramBuckets, [](std::size_t bucket) {
        return microseconds_json(histogram_bucket_start(bucket));
    });
    text.add_list("inputs", report.inputs.size(),
                  [&](std::size_t i) { return part_json(report.inputs[i]); });
    text.add_list("outputs", report.outputs.size(),
                  [&](std::size_t i) { return part_json(report.outputs[i]); });
    return std::move(text).end();
}

}  // namespace tribus
