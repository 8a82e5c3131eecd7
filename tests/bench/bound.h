#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tl/expected.hpp>

#include "core/distribution.h"
#include "core/time.h"
#include "tests/bench/latency.h"
#include "tests/bench/relay.h"
#include "tests/bench/subject.h"

namespace tribus::test {

/// The bound of a row that only informs.
inline constexpr double kNoBound = std::numeric_limits<double>::infinity();

/// One row of the table, measured in one run.
struct Figure {
    std::string row;
    double value = 0;
    double bound = 0;
    /// Factor that the machine's noise allows: the ratio of two runs of the anchor, at least 1.
    double allowance = 1;
    std::string note{};
};

using Figures = tl::expected<std::vector<Figure>, std::string>;
using Refused = tl::unexpected<std::string>;

struct BoundSettings {
    std::string program;     ///< `tribus`
    std::string heap_trap;   ///< preloaded into the program to count allocations
    std::string line;        ///< the GPIO line for PPM
    std::optional<int> cpu;  ///< processor for relay and product
    int priority = 80;
    Duration length = std::chrono::seconds(15);  ///< of each ratio in each run
    bool all_frames = false;                     ///< a million frames where they are counted
};

/// Settings for the product in real time.
inline bench::ApplianceSettings appliance(const BoundSettings& settings) {
    bench::ApplianceSettings appliance;
    appliance.program = settings.program;
    appliance.priority = settings.priority;
    appliance.cpu = settings.cpu;
    return appliance;
}

/// The anchor of ratios: a relay in real time, on the processor of the product.
inline bench::RelaySettings bare_relay(const BoundSettings& settings,
                                       bench::RelaySettings::Waits waits) {
    return {.waits = waits, .priority = settings.priority, .cpu = settings.cpu};
}

/// The anchor that keeps the product's deadline too, the least that a program with a failsafe can
/// do: it wakes 4.5 ms behind the next expected frame, more than a tick of the kernel.
inline bench::RelaySettings with_deadline(bench::RelaySettings bare,
                                          Duration period = bench::kFramePeriod) {
    bare.timeout = period + std::chrono::microseconds(4500);
    return bare;
}

inline std::string microseconds(Duration duration) {
    return fmt::format("{:.1f} us", static_cast<double>(duration.count()) / 1e3);
}

/// A figure that is the ratio of a time to that of its anchor, which was measured twice.
inline Figure ratio_figure(std::string row, double bound, Duration mine, Duration anchor,
                           Duration anchor_again) {
    return {.row = std::move(row),
            .value = ratio_of(mine, anchor),
            .bound = bound,
            .allowance = noise_allowance(anchor, anchor_again),
            .note = fmt::format("{} beside {}", microseconds(mine), microseconds(anchor))};
}

/// Rows of the table that are measured together.
struct Bound {
    std::string_view name;
    std::string_view says;
    bool ratio = false;  ///< the median of several runs counts; otherwise one run is exact
    Figures (*measure)(const BoundSettings&) = nullptr;
};

/// Bounds that are ratios of times.
std::vector<Bound> time_bounds();
/// Bounds with 64 pipelines that are ratios of times.
std::vector<Bound> scaling_bounds();
/// Bounds of a sensor bus: ratios and times.
std::vector<Bound> response_bounds();
/// Jitter of PPM on a GPIO line.
std::vector<Bound> ppm_bounds();
/// Bounds in instructions.
std::vector<Bound> instruction_bounds();
/// Bounds of the kernel's timers.
std::vector<Bound> clock_bounds();
/// Bounds that are other counts.
std::vector<Bound> count_bounds();

}  // namespace tribus::test
