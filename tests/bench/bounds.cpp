#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "core/distribution.h"
#include "pipelines/realtime/clock.h"
#include "tests/bench/bound.h"
#include "tests/bench/tester.h"

/// Prints a table of the bounds in real time and what this machine reaches. A ratio is the median
/// of several runs. Each run measures its anchor twice, which shows the noise. A time never makes
/// this program fail.
namespace tribus::test {
namespace {

struct ProcessorTimes {
    double busy = 0;
    double stolen = 0;
    double all = 0;
};

ProcessorTimes read_processor_times() {
    std::ifstream file("/proc/stat");
    std::string name;
    file >> name;
    constexpr int kFields = 8;  // user nice system idle iowait irq softirq steal
    constexpr int kIdle = 3;
    constexpr int kWaiting = 4;
    constexpr int kStolen = 7;
    ProcessorTimes times;
    for (int field = 0; field < kFields; ++field) {
        double value = 0;
        file >> value;
        times.all += value;
        times.busy += field == kIdle || field == kWaiting || field == kStolen ? 0 : value;
        times.stolen += field == kStolen ? value : 0;
    }
    return times;
}

/// Waits until little else runs. Returns how busy the machine was in the last second, in percent.
double wait_for_quiet(Duration patience) {
    constexpr double kQuietPercent = 6;
    const Instant end = monotonic_now() + patience;
    double busy = 100;
    do {
        const ProcessorTimes before = read_processor_times();
        bench::sleep_until(monotonic_now() + std::chrono::seconds(1));
        const ProcessorTimes after = read_processor_times();
        const double all = std::max(after.all - before.all, 1.0);
        busy = 100 * (after.busy - before.busy + after.stolen - before.stolen) / all;
    } while (busy > kQuietPercent && monotonic_now() < end && !bench::interrupted());
    return busy;
}

/// For an even number, the mean of the two middle values; zero without values.
double median_of(std::vector<double> values) {
    if (values.empty()) {
        return 0;
    }
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

/// Returns the median of one row over all runs.
Figure median_figure(const std::vector<std::vector<Figure>>& runs, std::size_t row) {
    std::vector<double> values;
    std::vector<double> allowances;
    for (const auto& run : runs) {
        values.push_back(run[row].value);
        allowances.push_back(run[row].allowance);
    }
    Figure figure = runs.back()[row];
    figure.value = median_of(values);
    figure.allowance = median_of(allowances);
    return figure;
}

bool holds(const Figure& figure) {
    return figure.value <= figure.bound * figure.allowance;
}

void print_heading() {
    fmt::print("{:<46} {:>9} {:>7} {:>6}  {}\n{}\n", "row", "measured", "bound", "A/A", "holds",
               std::string(90, '-'));
}

void print_figure(const Figure& figure) {
    const std::string allowance =
        figure.allowance == 1 ? std::string() : fmt::format("{:.2f}", figure.allowance);
    const bool informs = figure.bound == kNoBound;
    fmt::print("{:<46} {:>9.3f} {:>7} {:>6}  {:<3}  {}\n", figure.row, figure.value,
               informs ? "" : fmt::format("{:.2f}", figure.bound), allowance,
               informs ? "" : (holds(figure) ? "yes" : "NO"), figure.note);
    std::fflush(stdout);
}

struct Options {
    std::vector<std::string> only;
    int runs = 3;
    double seconds = 15;
    double patience = 60;
    bool unpinned = false;
    bool long_counts = false;
    std::string line;
};

bool measure_and_print(const Bound& bound, const BoundSettings& settings, const Options& options) {
    std::vector<std::vector<Figure>> runs;
    const int wanted = bound.ratio ? options.runs : 1;
    double busiest = 0;
    for (int run = 0; run < wanted && !bench::interrupted(); ++run) {
        if (bound.ratio) {
            busiest = std::max(busiest, wait_for_quiet(std::chrono::duration_cast<Duration>(
                                            std::chrono::duration<double>(options.patience))));
        }
        auto figures = bound.measure(settings);
        if (!figures) {
            fmt::print("{}: not measured: {}\n", bound.name, figures.error());
            return false;
        }
        runs.push_back(std::move(*figures));
    }
    for (std::size_t row = 0; !runs.empty() && row < runs.front().size(); ++row) {
        Figure figure = bound.ratio ? median_figure(runs, row) : runs.front()[row];
        if (busiest > 10) {
            figure.note += fmt::format("; machine {:.0f} % busy before", busiest);
        }
        print_figure(figure);
    }
    return true;
}

int run(const Options& options) {
    std::vector<Bound> bounds = time_bounds();
    for (const auto& further : {scaling_bounds(), clock_bounds(), response_bounds(), count_bounds(),
                                instruction_bounds()}) {
        bounds.insert(bounds.end(), further.begin(), further.end());
    }
    if (!options.line.empty()) {
        const std::vector<Bound> ppm = ppm_bounds();
        bounds.insert(bounds.end(), ppm.begin(), ppm.end());
    }
    for (const std::string& name : options.only) {
        if (std::ranges::find(bounds, name, &Bound::name) == bounds.end()) {
            fmt::print(stderr, "--only {}: there is no such row; allowed:", name);
            for (const Bound& bound : bounds) {
                fmt::print(stderr, " {}", bound.name);
            }
            fmt::print(stderr, "\n");
            return 2;
        }
    }
    BoundSettings settings;
    settings.program = TRIBUS_PROGRAM;
    settings.heap_trap = TRIBUS_HEAP_TRAP;
    settings.line = options.line;
    settings.length =
        std::chrono::duration_cast<Duration>(std::chrono::duration<double>(options.seconds));
    settings.all_frames = options.long_counts;
    if (!options.unpinned && bench::processor_count() > 1) {
        settings.cpu = bench::processor_count() - 1;
    }
    bench::watch_for_interruption();
    const bench::AwakeProcessors awake;
    print_heading();
    bool fine = true;
    for (const Bound& bound : bounds) {
        const bool wanted = options.only.empty() ||
                            std::ranges::find(options.only, bound.name) != options.only.end();
        if (wanted && !bench::interrupted()) {
            fine = measure_and_print(bound, settings, options) && fine;
        }
    }
    return fine && !bench::interrupted() ? 0 : 1;
}

}  // namespace
}  // namespace tribus::test

int main(int argc, char** argv) {
    CLI::App app{"What real time must reach, beside what it reaches on this machine", "bounds"};
    tribus::test::Options options;
    app.add_option(
           "--only", options.only,
           "latency,load,age,lateness,cpu,spawn,scaling,clock,response,memory,heap,calls,lost,"
           "codecs,garbage,engine,link,daemon: some rows")
        ->delimiter(',');
    app.add_option("--runs", options.runs, "Of each ratio; the median counts")
        ->check(CLI::Range(1, 99))
        ->capture_default_str();
    app.add_option("--seconds", options.seconds, "For each run of a ratio")
        ->check(CLI::Range(1.0, 3600.0))
        ->capture_default_str();
    app.add_option("--patience", options.patience, "Seconds to wait for a quiet machine")
        ->capture_default_str();
    app.add_flag("--unpinned", options.unpinned, "Relay and product on any CPU, not on the last");
    app.add_flag("--long", options.long_counts, "A million frames where lost ones are counted");
    app.add_option("--line", options.line,
                   "A GPIO line with the PPM of a receiver whose sticks rest: adds the row ppm");
    CLI11_PARSE(app, argc, argv);
    return tribus::test::run(options);
}
