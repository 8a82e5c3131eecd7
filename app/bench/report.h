#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/bench/distribution.h"
#include "core/time.h"

namespace tribus::bench {

/// One figure and the one that it is compared with.
struct Measurement {
    std::string group;  ///< "latency", "lateness", "age", "codecs", "capacity" or "ppm"
    std::string what;
    double figure = 0;
    std::optional<double> anchor{};
    std::string unit = "ns";
    std::string reading{};

    /// `figure` divided by `anchor`; nothing without an anchor.
    std::optional<double> ratio() const {
        return anchor && *anchor > 0 ? std::optional(figure / *anchor) : std::nullopt;
    }
};

/// A distribution for the plot.
struct Curve {
    std::string group;
    std::string name;
    Distribution times;
};

/// Result of `tribus bench`.
struct Report {
    std::vector<std::string> missing;  ///< what was not permitted, in sentences
    std::vector<Measurement> measurements;
    std::vector<Curve> curves;
    std::vector<std::string> broken;  ///< requirements that do not hold, in sentences

    /// Adds a measurement in nanoseconds.
    void add(std::string_view group, std::string what, Duration figure,
             std::optional<Duration> anchor, std::string reading);
};

/// For people, at most `columns` wide.
std::string report_text(const Report& report, std::size_t columns);
/// One JSON object; times in nanoseconds.
std::string report_json(const Report& report);

/// The distributions as a drawing: one panel a group, percentiles to the right, time upwards; both
/// scales are logarithmic, to show rare and late frames.
std::string report_svg(const Report& report);

}  // namespace tribus::bench
