#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/time.h"

/// Measures what tribus adds to the least that any program does.
namespace tribus::bench {

/// A requirement of `--require` on the latency.
struct Requirement {
    std::string text;    ///< as given
    std::string what;    ///< "p50", "p90" or "p99"
    bool added = false;  ///< compare the difference to the bare relay, not the whole latency
    Duration most{};
};

/// Parses "p99=200us" or "added-p50=20us". The error says what is allowed.
tl::expected<Requirement, std::string> parse_requirement(std::string_view text);

/// One figure and the one that it is compared with.
struct Measurement {
    std::string group;  ///< "latency", "cpu" or "lateness"
    std::string what;
    double figure = 0;
    std::optional<double> anchor{};
    std::string unit = "ns";
    std::string reading{};
};

struct Report {
    std::vector<std::string> missing{};  ///< what was not permitted, in sentences
    std::vector<Measurement> measurements{};
    std::vector<std::string> broken{};  ///< requirements that do not hold, in sentences

    /// Adds a time beside that of `peer`, which was measured twice: its noise is allowed for.
    void add(std::string_view group, std::string what, Duration figure, Duration anchor,
             Duration anchor_again, std::string_view peer);
    /// Adds a sentence to `broken` unless the latency meets the requirement.
    void judge(const Requirement& requirement);
};

/// For people, in 80 columns.
std::string report_text(const Report& report);
/// One JSON object; times in nanoseconds.
std::string report_json(const Report& report);

/// Adds latency and processor time: of i.Bus frames of 18 channels, one in 7 ms, through tribus and
/// through a relay that only waits, reads and writes. They go over pseudo-terminals, or out of the
/// second of `ports` and into the first, which is wired to it. The error is a sentence.
tl::expected<void, std::string> add_frames(Report& report, const std::vector<std::string>& ports,
                                           Duration length);

/// Adds the lateness of an output of schedule `grid` beside that of a thread that only sleeps.
tl::expected<void, std::string> add_lateness(Report& report, Duration length);

}  // namespace tribus::bench
