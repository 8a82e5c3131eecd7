#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "core/distribution.h"
#include "pipelines/realtime/clock.h"
#include "tests/bench/age.h"
#include "tests/bench/bound.h"
#include "tests/bench/latency.h"
#include "tests/bench/lateness.h"
#include "tests/bench/subject.h"
#include "tests/bench/tester.h"

namespace tribus::test {
namespace {

using namespace bench;

/// Starts and warms up all subjects, then measures all of them in each period.
tl::expected<std::vector<LatencyResult>, std::string> measure_together(
    std::vector<tl::expected<Subject, std::string>> subjects, Duration length) {
    std::vector<Subject*> ready;
    for (auto& subject : subjects) {
        subject = carrying(std::move(subject));
        if (!subject) {
            return Refused(subject.error());
        }
        ready.push_back(&*subject);
    }
    const TesterPriority priority;
    return measure_latency(ready, length);
}

Figure percentile_figure(const std::string& row, double percent, double bound,
                         const Distribution& mine, const Distribution& anchor,
                         const Distribution& again) {
    return ratio_figure(fmt::format("{}, p{:.0f}", row, percent), bound, mine.percentile(percent),
                        anchor.percentile(percent), again.percentile(percent));
}

Figures added_latency(const BoundSettings& settings) {
    const auto bare = bare_relay(settings, RelaySettings::Waits::poll);
    std::vector<tl::expected<Subject, std::string>> subjects;
    subjects.push_back(Subject::relay(1, bare));
    subjects.push_back(Subject::appliance(1, appliance(settings)));
    subjects.push_back(Subject::relay(1, bare));
    subjects.push_back(Subject::relay(1, with_deadline(bare)));
    const auto results = measure_together(std::move(subjects), settings.length);
    if (!results) {
        return Refused(results.error());
    }
    std::vector<Figure> figures;
    for (const auto& [percent, bound] :
         std::array<std::pair<double, double>, 3>{{{50, 1.05}, {90, 1.10}, {99, 1.10}}}) {
        figures.push_back(percentile_figure("latency / bare FIFO relay", percent, bound,
                                            (*results)[1].latency, (*results)[0].latency,
                                            (*results)[2].latency));
        figures.back().note += fmt::format(
            ", with a deadline {} us", (*results)[3].latency.percentile(percent).count() / 1000);
    }
    return figures;
}

Figures latency_under_load(const BoundSettings& settings) {
    auto load = Process::execute({"stress-ng", "--cpu", "2", "--quiet"});
    if (!load) {
        return Refused(load.error());
    }
    const RelaySettings bare;
    std::vector<tl::expected<Subject, std::string>> subjects;
    subjects.push_back(Subject::relay(1, bare));
    subjects.push_back(Subject::appliance(1, appliance(settings)));
    subjects.push_back(Subject::relay(1, bare));
    subjects.push_back(Subject::relay(1, bare_relay(settings, RelaySettings::Waits::poll)));
    const auto results = measure_together(std::move(subjects), settings.length);
    if (!results) {
        return Refused(results.error());
    }
    const auto latency = [&](std::size_t i) { return (*results)[i].latency; };
    Figure figure = percentile_figure("latency under load / relay without FIFO", 99, 0.25,
                                      latency(1), latency(0), latency(2));
    figure.note += fmt::format(", bare FIFO relay {} us", latency(3).percentile(99).count() / 1000);
    return std::vector{figure};
}

Figures age_of_data(const BoundSettings& settings) {
    const auto ages = measure_age(appliance(settings), settings.length);
    if (!ages) {
        return Refused(ages.error());
    }
    std::vector<Figure> figures;
    for (const auto& [percent, bound] :
         std::array<std::pair<double, double>, 2>{{{50, 0.05}, {99, 0.10}}}) {
        figures.push_back(percentile_figure("age, follow / free-running writer", percent, bound,
                                            ages->follow, ages->free, ages->free));
        figures.push_back(percentile_figure("age, grid locked / free-running writer", percent,
                                            bound, ages->locked, ages->free, ages->free));
    }
    return figures;
}

/// Reads cyclictest's histogram: lines of microseconds, rounded down, and counts.
Distribution read_histogram(int file) {
    std::string text(1 << 20, '\0');
    const ssize_t count = ::pread(file, text.data(), text.size(), 0);
    text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    std::istringstream lines(text);
    std::vector<Duration> samples;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream numbers(line);
        std::int64_t microseconds = 0;
        std::size_t times = 0;
        if (line.starts_with('#') || !(numbers >> microseconds >> times)) {
            continue;
        }
        const Duration middle = std::chrono::microseconds(microseconds) + Duration(500);
        samples.insert(samples.end(), times, middle);
    }
    return Distribution(std::move(samples));
}

Figures grid_lateness(const BoundSettings& settings) {
    const int histogram = ::memfd_create("histogram", 0);
    const auto loops = settings.length / kGridPeriod;
    const int cpu = settings.cpu.value_or(processor_count() - 1);
    auto cyclictest = Process::execute(
        {"cyclictest", "--quiet", "--mlockall", fmt::format("--priority={}", settings.priority),
         "--interval=7000", fmt::format("--affinity={}", cpu), "--threads=1",
         fmt::format("--loops={}", loops), "--histogram=20000",
         fmt::format("--histfile=/proc/self/fd/{}", histogram)},
        {histogram});
    if (!cyclictest) {
        return Refused(cyclictest.error());
    }
    auto late =
        measure_lateness({.priority = settings.priority, .cpu = cpu, .length = settings.length});
    for (int i = 0; i < 500 && cyclictest->runs(); ++i) {
        sleep_until(monotonic_now() + std::chrono::milliseconds(10));
    }
    cyclictest->end();
    const Distribution beside = read_histogram(histogram);
    ::close(histogram);
    if (!late || beside.empty()) {
        return Refused(late ? "cyclictest told nothing: " + cyclictest->errors() : late.error());
    }
    std::vector<Figure> figures;
    for (const double percent : {50.0, 90.0}) {
        figures.push_back(percentile_figure("grid lateness / cyclictest", percent, 1.10, late->grid,
                                            beside, late->bare));
        figures.back().allowance = 1;
        figures.back().note +=
            fmt::format(", bare timer loop {} us", late->bare.percentile(percent).count() / 1000);
    }
    return figures;
}

Figures processor_time(const BoundSettings& settings) {
    const auto bare = bare_relay(settings, RelaySettings::Waits::epoll);
    std::vector<tl::expected<Subject, std::string>> subjects;
    subjects.push_back(Subject::relay(1, bare));
    subjects.push_back(Subject::appliance(1, appliance(settings)));
    subjects.push_back(Subject::command({"socat", "{in},raw,echo=0", "{out},raw,echo=0"}));
    subjects.push_back(Subject::relay(1, bare));
    subjects.push_back(Subject::relay(1, with_deadline(bare)));
    const auto results = measure_together(std::move(subjects), settings.length);
    if (!results) {
        return Refused(results.error());
    }
    const auto used = [&](std::size_t i) { return (*results)[i].processor_time_per_frame; };
    std::vector<Figure> figures{
        ratio_figure("CPU time a frame / bare FIFO epoll relay", 1.10, used(1), used(0), used(3)),
        ratio_figure("CPU time a frame / socat", 0.75, used(1), used(2), used(2))};
    figures[0].note += ", with a deadline " + microseconds(used(4));
    return figures;
}

/// Returns the time from the start of a program until it writes something, while frames are sent to
/// it.
template <class Start>
tl::expected<Duration, std::string> time_to_first_frame(Start start) {
    constexpr Duration kSendEvery = std::chrono::microseconds(200);
    const Instant before = monotonic_now();
    tl::expected<Subject, std::string> subject = start();
    if (!subject) {
        return Refused(subject.error());
    }
    Instant next_send = before;
    while (monotonic_now() - before < std::chrono::seconds(10) && !interrupted()) {
        // While the near end is not open, a wait for the far end returns at once.
        std::array<std::uint8_t, 64> buffer{};
        if (::read(subject->lane().out_descriptor(), buffer.data(), buffer.size()) > 0) {
            return monotonic_now() - before;
        }
        if (monotonic_now() >= next_send) {
            subject->lane().send();
            next_send += kSendEvery;
        }
        sleep_until(monotonic_now() + std::chrono::microseconds(20));
    }
    return Refused("nothing came out: " + subject->process().errors());
}

Figures spawn(const BoundSettings& settings) {
    constexpr int kStarts = 20;
    std::vector<Duration> mine;
    std::vector<Duration> its;
    for (int i = 0; i < kStarts && !interrupted(); ++i) {
        const auto ours =
            time_to_first_frame([&] { return Subject::appliance(1, appliance(settings)); });
        const auto socat = time_to_first_frame([] {
            return Subject::command({"socat", "{in},raw,echo=0", "{out},raw,echo=0"});
        });
        if (!ours || !socat) {
            return Refused(ours ? socat.error() : ours.error());
        }
        mine.push_back(*ours);
        its.push_back(*socat);
    }
    const Distribution anchor(std::move(its));
    return std::vector{percentile_figure("spawn to first frame / socat", 50, 1.0,
                                         Distribution(std::move(mine)), anchor, anchor)};
}

}  // namespace

std::vector<Bound> time_bounds() {
    return {
        {"latency", "added latency, paired, under the same SCHED_FIFO", true, added_latency},
        {"load", "the same under stress-ng --cpu 2", true, latency_under_load},
        {"age", "age of data against a free-running writer", true, age_of_data},
        {"lateness", "a grid beside cyclictest on the same CPU", true, grid_lateness},
        {"cpu", "processor time a frame with one pipeline", true, processor_time},
        {"spawn", "from the start to the first translated frame", true, spawn},
    };
}

}  // namespace tribus::test
