#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/bench/report.h"
#include "app/bench/requirement.h"
#include "core/time.h"

/// The six measurements of `tribus bench`. Each adds its rows and curves to the report; the error
/// is a sentence.
namespace tribus::bench {

/// Settings of all measurements.
struct BenchSettings {
    Duration length = std::chrono::seconds(20);  ///< of all together
    std::optional<int> priority;                 ///< real-time priority, if permitted
    std::vector<Requirement> requirements;
    /// Two real ports connected by a wire, for the latency.
    struct Ports {
        std::string in;
        std::string out;
    };
    std::optional<Ports> ports;
    std::string line;  ///< the GPIO line for PPM
};

using Measured = tl::expected<void, std::string>;

Measured add_latency(Report& report, const BenchSettings& settings, Duration length);
Measured add_lateness(Report& report, const BenchSettings& settings, Duration length);
Measured add_age(Report& report, const BenchSettings& settings, Duration length);
Measured add_codecs(Report& report, const BenchSettings& settings, Duration length);
Measured add_capacity(Report& report, const BenchSettings& settings, Duration length);
Measured add_ppm(Report& report, const BenchSettings& settings, Duration length);

/// One measurement, with its share of the total time.
struct BenchPart {
    std::string_view name;
    double share = 0;
    Measured (*add)(Report&, const BenchSettings&, Duration) = nullptr;
};
inline constexpr std::string_view kPpmPart = "ppm";
/// All measurements, in the order in which they run. The last one needs `BenchSettings::line`.
const std::vector<BenchPart>& bench_parts();

}  // namespace tribus::bench
