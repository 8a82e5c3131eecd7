#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/bench/subject.h"
#include "core/time.h"

namespace tribus::test {

/// One row of the table, from one run.
struct Figure {
    std::string row;
    double value = 0;
    double bound = 0;
    /// What the machine's own noise allows on top: the anchor over itself, at least 1.
    double allowance = 1;
    std::string note{};
};

using Figures = tl::expected<std::vector<Figure>, std::string>;
using Refused = tl::unexpected<std::string>;

struct BoundSettings {
    std::string program;     ///< `tribus`
    std::string heap_trap;   ///< loaded into it where allocations are counted
    std::optional<int> cpu;  ///< what relay and product are pinned to
    int priority = 80;
    Duration length = std::chrono::seconds(15);  ///< of each ratio, each run
    bool all_frames = false;                     ///< a million where frames are counted
};

/// The product in real time, as it is measured.
inline bench::ApplianceSettings appliance(const BoundSettings& settings) {
    bench::ApplianceSettings appliance;
    appliance.program = settings.program;
    appliance.priority = settings.priority;
    appliance.cpu = settings.cpu;
    return appliance;
}

/// Some rows that are measured together.
struct Bound {
    std::string_view name;
    std::string_view says;
    bool ratio = false;  ///< the median of several runs counts; else one run is exact
    Figures (*measure)(const BoundSettings&) = nullptr;
};

/// Those that are ratios of times.
std::vector<Bound> time_bounds();
/// Those of a sensor bus, ratios and times.
std::vector<Bound> response_bounds();
/// Those that are instructions.
std::vector<Bound> instruction_bounds();
/// Those that are other counts.
std::vector<Bound> count_bounds();

}  // namespace tribus::test
