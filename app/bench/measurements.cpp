#include "app/bench/measurements.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "app/bench/age.h"
#include "app/bench/codec_cost.h"
#include "app/bench/latency.h"
#include "app/bench/lateness.h"
#include "app/bench/ports.h"
#include "app/bench/ppm.h"
#include "app/bench/subject.h"
#include "app/bench/table.h"
#include "app/bench/tester.h"

namespace tribus::bench {
namespace {

constexpr std::array<double, 3> kShownPercentiles{50, 90, 99};

RelaySettings relay_settings(const BenchSettings& settings, RelaySettings::Waits waits) {
    return {.waits = waits, .priority = settings.priority, .cpu = std::nullopt};
}

ApplianceSettings appliance_settings(const BenchSettings& settings) {
    ApplianceSettings appliance;
    appliance.priority = settings.priority;
    return appliance;
}

/// Adds p50, p90 and p99, judged with the noise between the two measurements of the anchor.
void add_percentiles(Report& report, std::string_view group, const Distribution& figure,
                     const Distribution& anchor, const Distribution& anchor_again,
                     const std::string& peer) {
    for (const double percent : kShownPercentiles) {
        const Duration mine = figure.percentile(percent);
        const Duration its = anchor.percentile(percent);
        const double noise = noise_allowance(its, anchor_again.percentile(percent));
        report.add(group, fmt::format("p{:.0f}", percent), mine, its,
                   reading_of(ratio_of(mine, its), noise, peer));
    }
}

void judge(Report& report, const BenchSettings& settings, const Distribution& whole,
           const Distribution& bare) {
    for (const Requirement& requirement : settings.requirements) {
        if (auto sentence = broken(requirement, whole.percentile(requirement.percent),
                                   bare.percentile(requirement.percent))) {
            report.broken.push_back(std::move(*sentence));
        }
    }
}

Measured add_latency_over_ports(Report& report, const BenchSettings& settings, Duration length) {
    auto result = measure_ports(settings.ports->in, settings.ports->out, settings.priority, length);
    if (!result) {
        return tl::unexpected(result.error());
    }
    add_percentiles(report, "latency", result->engine, result->bare, result->bare_again,
                    "a bare reader");
    judge(report, settings, result->engine, result->bare);
    report.curves.push_back({"latency", "tribus", result->engine});
    report.curves.push_back({"latency", "bare reader", result->bare});
    return {};
}

}  // namespace

Measured add_latency(Report& report, const BenchSettings& settings, Duration length) {
    if (settings.ports) {
        return add_latency_over_ports(report, settings, length);
    }
    const auto relay = relay_settings(settings, RelaySettings::Waits::poll);
    auto anchor = Subject::relay(1, relay);
    auto appliance = Subject::appliance(1, appliance_settings(settings));
    auto anchor_again = Subject::relay(1, relay);
    std::array<Subject*, 3> subjects{};
    std::size_t count = 0;
    for (auto* subject : {&anchor, &appliance, &anchor_again}) {
        if (!*subject) {
            return tl::unexpected(subject->error());
        }
        if (auto carries = (*subject)->wait_until_it_carries(); !carries) {
            return tl::unexpected(carries.error());
        }
        subjects[count++] = &**subject;
    }
    const TesterPriority priority;
    const std::vector<LatencyResult> results = measure_latency(subjects, length);
    for (const LatencyResult& result : results) {
        if (result.latency.empty() && !interrupted()) {
            return tl::unexpected(fmt::format(
                "frames were lost or came out broken ({} and {}); does another program use the "
                "same pseudo-terminals, one that waits for a device such as /dev/pts/0?",
                result.lost, result.torn));
        }
    }
    const Distribution& bare = results[0].latency;
    add_percentiles(report, "latency", results[1].latency, bare, results[2].latency,
                    "a bare relay");
    report.measurements.push_back(
        {.group = "latency",
         .what = "frames lost or torn",
         .figure = static_cast<double>(results[1].lost + results[1].torn),
         .unit = "frames",
         .reading = fmt::format("of {}", results[1].latency.size() + results[1].lost)});
    judge(report, settings, results[1].latency, bare);
    report.curves.push_back({"latency", "tribus", results[1].latency});
    report.curves.push_back({"latency", "bare relay", bare});
    report.curves.push_back({"latency", "bare relay again", results[2].latency});
    return {};
}

Measured add_lateness(Report& report, const BenchSettings& settings, Duration length) {
    const std::optional<int> last =
        processor_count() > 1 ? std::optional(processor_count() - 1) : std::nullopt;
    auto result = measure_lateness({.priority = settings.priority, .cpu = last, .length = length});
    if (!result) {
        return tl::unexpected(result.error());
    }
    add_percentiles(report, "lateness", result->grid, result->bare, result->bare,
                    "a bare timer loop");
    report.curves.push_back({"lateness", "tribus, grid", std::move(result->grid)});
    report.curves.push_back({"lateness", "bare timer loop", std::move(result->bare)});
    return {};
}

Measured add_age(Report& report, const BenchSettings& settings, Duration length) {
    auto result = measure_age(appliance_settings(settings), length);
    if (!result) {
        return tl::unexpected(result.error());
    }
    const std::string peer = "a free-running writer";
    for (const double percent : {50.0, 99.0}) {
        const Duration anchor = result->free.percentile(percent);
        const auto add = [&](const char* name, const Distribution& ages) {
            const Duration age = ages.percentile(percent);
            report.add("age", fmt::format("{}, p{:.0f}", name, percent), age, anchor,
                       reading_of(ratio_of(age, anchor), 1, peer));
        };
        add("follow", result->follow);
        add("grid, locked", result->locked);
    }
    report.curves.push_back({"age", "follow", std::move(result->follow)});
    report.curves.push_back({"age", "grid, locked", std::move(result->locked)});
    report.curves.push_back({"age", "grid, free", std::move(result->free)});
    return {};
}

Measured add_codecs(Report& report, const BenchSettings& /*settings*/, Duration length) {
    for (const CodecCost& cost : measure_codecs(length)) {
        const auto add = [&](const char* way, double nanoseconds) {
            const double share = nanoseconds / static_cast<double>(kFramePeriod.count()) * 100;
            report.add("codecs", fmt::format("{} {}", cost.protocol, way),
                       Duration(static_cast<std::int64_t>(nanoseconds)), std::nullopt,
                       fmt::format("{:.4f} % of a core each 7 ms", share));
        };
        add("decode", cost.decode_ns);
        add("encode", cost.encode_ns);
    }
    return {};
}

namespace {

tl::expected<Duration, std::string> time_per_frame(tl::expected<Subject, std::string> subject,
                                                   Duration length) {
    if (!subject) {
        return tl::unexpected(subject.error());
    }
    if (auto carries = subject->wait_until_it_carries(kFramePeriod); !carries) {
        return tl::unexpected(carries.error());
    }
    const TesterPriority priority;
    const auto rounds = static_cast<std::uint64_t>(length / kFramePeriod);
    return drive(*subject, {.rounds = std::max<std::uint64_t>(rounds, 1)}).processor_time_per_frame;
}

/// The number of pipelines that fill one core, if each further one costs what it did between 1 and
/// `many`.
double pipelines_per_core(Duration one, Duration each_of_many, std::size_t many) {
    const auto n = static_cast<double>(many);
    const double whole = static_cast<double>(each_of_many.count()) * n;
    const double further = std::max((whole - static_cast<double>(one.count())) / (n - 1), 1.0);
    return n + (static_cast<double>(kFramePeriod.count()) - whole) / further;
}

}  // namespace

Measured add_capacity(Report& report, const BenchSettings& settings, Duration length) {
    constexpr std::size_t kMany = 64;
    const auto relay = relay_settings(settings, RelaySettings::Waits::epoll);
    const ApplianceSettings appliance = appliance_settings(settings);
    std::array<Duration, 2> mine{};
    std::array<Duration, 2> bare{};
    for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
        const std::size_t lanes = i == 0 ? 1 : kMany;
        const auto its = time_per_frame(Subject::relay(lanes, relay), length / 4);
        const auto ours = time_per_frame(Subject::appliance(lanes, appliance), length / 4);
        if (!its || !ours) {
            return tl::unexpected(its ? ours.error() : its.error());
        }
        bare[i] = *its;
        mine[i] = *ours;
        report.add("capacity",
                   lanes == 1 ? "a frame, 1 pipeline" : fmt::format("a frame, {} pipelines", lanes),
                   *ours, *its, reading_of(ratio_of(*ours, *its), 1, "a bare relay"));
    }
    report.measurements.push_back({.group = "capacity",
                                   .what = "pipelines that fill a core",
                                   .figure = pipelines_per_core(mine[0], mine[1], kMany),
                                   .anchor = pipelines_per_core(bare[0], bare[1], kMany),
                                   .unit = "pipelines",
                                   .reading = "extrapolated"});
    return {};
}

Measured add_ppm(Report& report, const BenchSettings& settings, Duration length) {
    auto result = measure_ppm(settings.line, length);
    if (!result) {
        return tl::unexpected(result.error());
    }
    add_percentiles(report, "ppm", result->stamped, result->bare, result->bare,
                    "a reader's own clock");
    report.measurements.push_back(
        {.group = "ppm",
         .what = "frames refused",
         .figure = static_cast<double>(result->refused),
         .unit = "frames",
         .reading = fmt::format("of {}, {} channels", result->frames + result->refused,
                                result->channels)});
    report.curves.push_back({"ppm", "tribus, time stamps", std::move(result->stamped)});
    report.curves.push_back({"ppm", "a reader's own clock", std::move(result->bare)});
    return {};
}

const std::vector<BenchPart>& bench_parts() {
    static const std::vector<BenchPart> parts{
        {"latency", 0.4, add_latency}, {"lateness", 0.15, add_lateness}, {"age", 0.2, add_age},
        {"codecs", 0.05, add_codecs},  {"capacity", 0.2, add_capacity},  {kPpmPart, 0.2, add_ppm}};
    return parts;
}

}  // namespace tribus::bench
