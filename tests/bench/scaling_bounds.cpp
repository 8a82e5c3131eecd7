#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/distribution.h"
#include "tests/bench/bound.h"
#include "tests/bench/latency.h"
#include "tests/bench/subject.h"
#include "tests/bench/tester.h"

namespace tribus::test {
namespace {

using namespace bench;

constexpr std::size_t kMany = 64;
/// Frames as a receiver of i.Bus sends them, to outputs whose least period is a bit shorter: after
/// a stall of the machine an output must not hold up each frame by the period of the one before.
constexpr Duration kReceiverPeriod = std::chrono::microseconds(7700);
constexpr Duration kLeastPeriod = std::chrono::milliseconds(7);

using Measured = tl::expected<LatencyResult, std::string>;

/// The subject ends before this returns.
Measured measure(tl::expected<Subject, std::string> started, const BoundSettings& settings,
                 bool at_one_instant) {
    auto subject = carrying(std::move(started));
    if (!subject) {
        return Refused(subject.error());
    }
    const TesterPriority priority;
    const auto rounds = static_cast<std::uint64_t>(settings.length / 4 / kReceiverPeriod);
    return drive(*subject,
                 {.period = kReceiverPeriod, .rounds = rounds, .at_one_instant = at_one_instant});
}

/// The product between its anchors, all with 64 pipelines.
struct Compared {
    LatencyResult before;
    LatencyResult ours;
    LatencyResult with_deadline;
    LatencyResult after;
};

tl::expected<Compared, std::string> compare(const BoundSettings& settings,
                                            const ApplianceSettings& ours, bool at_one_instant) {
    const RelaySettings bare = bare_relay(settings, RelaySettings::Waits::epoll);
    std::array<Measured, 4> measured{
        measure(Subject::relay(kMany, bare), settings, at_one_instant),
        measure(Subject::appliance(kMany, ours), settings, at_one_instant),
        measure(Subject::relay(kMany, with_deadline(bare, kReceiverPeriod)), settings,
                at_one_instant),
        measure(Subject::relay(kMany, bare), settings, at_one_instant)};
    for (const Measured& one : measured) {
        if (!one) {
            return Refused(one.error());
        }
    }
    return Compared{.before = std::move(*measured[0]),
                    .ours = std::move(*measured[1]),
                    .with_deadline = std::move(*measured[2]),
                    .after = std::move(*measured[3])};
}

/// The ratio of one duration of each of them.
template <class DurationOf>
Figure compared_figure(const std::string& row, double bound, const Compared& compared,
                       DurationOf duration_of) {
    Figure figure = ratio_figure(row, bound, duration_of(compared.ours),
                                 duration_of(compared.before), duration_of(compared.after));
    figure.note += ", with a deadline " + microseconds(duration_of(compared.with_deadline));
    return figure;
}

Figures scaling(const BoundSettings& settings) {
    ApplianceSettings ours = appliance(settings);
    ours.period = kLeastPeriod;
    const auto one = measure(Subject::appliance(1, ours), settings, false);
    if (!one) {
        return Refused(one.error());
    }
    const auto spread = compare(settings, ours, false);
    if (!spread) {
        return Refused(spread.error());
    }
    const auto burst = compare(settings, ours, true);
    if (!burst) {
        return Refused(burst.error());
    }
    const auto cost = [](const LatencyResult& result) { return result.processor_time_per_frame; };
    const auto p99 = [](const LatencyResult& result) { return result.latency.percentile(99); };
    return std::vector<Figure>{
        ratio_figure("cost a frame at 64 pipelines / at 1", 0.6, cost(spread->ours), cost(*one),
                     cost(*one)),
        compared_figure("CPU time a frame, 64 pipelines / bare relay", 1.20, *spread, cost),
        compared_figure("latency, 64 pipelines / bare relay, p99", 1.30, *spread, p99),
        compared_figure("64 frames at one instant / bare relay", 1.15, *burst, cost)};
}

}  // namespace

std::vector<Bound> scaling_bounds() {
    return {{"scaling", "processor time and latency of a frame with 64 pipelines", true, scaling}};
}

}  // namespace tribus::test
