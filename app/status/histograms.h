#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/appliance/appliance.h"
#include "core/time.h"
#include "pipelines/realtime/histogram.h"

/// Whole distributions of times, for who asks for them; a status has only their quantiles.
namespace tribus {

struct TimeHistogram {
    std::string_view what;  ///< as in a status, such as "latency"
    HistogramReading last_minute;
    HistogramReading since_start;
};

/// Those of one input or output.
struct PartHistograms {
    std::string name;
    std::vector<TimeHistogram> histograms;
};

struct HistogramsReport {
    Instant now{};
    std::vector<PartHistograms> inputs;
    std::vector<PartHistograms> outputs;
};

/// Reads what the data thread counts anyway.
HistogramsReport histograms_of(const Appliance& appliance, Instant now);

/// The answer to `histograms` (docs/status.md), in one line. Pure.
std::string histograms_json(const HistogramsReport& report);

}  // namespace tribus
