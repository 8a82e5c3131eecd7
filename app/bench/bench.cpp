#include "app/bench/bench.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "app/bench/measurements.h"
#include "app/bench/report.h"
#include "app/bench/requirement.h"
#include "app/bench/tester.h"
#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/streams.h"
#include "app/journal/print_error.h"
#include "config/language/mistakes.h"
#include "pipelines/realtime/scheduling.h"

namespace tribus {
namespace {

using bench::BenchPart;
using bench::BenchSettings;
using bench::Report;

/// Default priority of `tribus run`.
constexpr int kPriority = 80;
constexpr std::size_t kMostColumns = 100;

struct BenchOptions {
    double seconds = 20;
    std::vector<std::string> ports;
    std::string line;
    std::vector<std::string> only;
    std::vector<std::string> require;
    std::string plot;
    std::string format = "text";
};

/// The sentences of `tribus run`, from a thread that tries to become real-time.
std::vector<std::string> missing_realtime() {
    std::vector<std::string> missing;
    std::thread([&missing] {
        missing =
            make_realtime({.priority = kPriority, .cpu = std::nullopt, .realtime = true}).missing;
    }).join();
    ::munlockall();
    return missing;
}

/// Those that --only names; all if it is left out, PPM with --line.
tl::expected<std::vector<BenchPart>, std::string> chosen_parts(const BenchOptions& options) {
    const std::vector<std::string>& only = options.only;
    if (only.empty()) {
        std::vector<BenchPart> all = bench::bench_parts();
        std::erase_if(all, [&options](const BenchPart& part) {
            return part.name == bench::kPpmPart && options.line.empty();
        });
        return all;
    }
    std::vector<std::string_view> names;
    for (const BenchPart& part : bench::bench_parts()) {
        names.push_back(part.name);
    }
    std::vector<BenchPart> parts;
    for (const std::string& name : only) {
        const auto found = std::find(names.begin(), names.end(), name);
        if (found == names.end()) {
            return tl::unexpected(fmt::format("--only {}: there is no such measurement; {}", name,
                                              suggestion(name, names)));
        }
        parts.push_back(bench::bench_parts()[static_cast<std::size_t>(found - names.begin())]);
    }
    return parts;
}

tl::expected<BenchSettings, std::string> settings_of(const BenchOptions& options,
                                                     const std::vector<BenchPart>& parts) {
    BenchSettings settings;
    settings.length =
        std::chrono::duration_cast<Duration>(std::chrono::duration<double>(options.seconds));
    for (const std::string& text : options.require) {
        auto requirement = bench::parse_requirement(text);
        if (!requirement) {
            return tl::unexpected(requirement.error());
        }
        settings.requirements.push_back(std::move(*requirement));
    }
    const bool latency =
        std::any_of(parts.begin(), parts.end(), [](auto& part) { return part.name == "latency"; });
    if (!settings.requirements.empty() && !latency) {
        return tl::unexpected(
            std::string("--require judges the latency, which --only leaves out; add latency"));
    }
    if (!options.ports.empty()) {
        settings.ports = {.in = options.ports[0], .out = options.ports[1]};
    }
    settings.line = options.line;
    const bool ppm = std::ranges::count(parts, bench::kPpmPart, &BenchPart::name) > 0;
    if (ppm != !options.line.empty()) {
        return tl::unexpected(
            std::string(ppm ? "--only ppm needs --line, the GPIO line that a receiver is "
                              "connected to, such as --line GPIO17"
                            : "--line is for the measurement ppm, which --only leaves out; add "
                              "ppm"));
    }
    return settings;
}

bool write_plot(const std::string& path, const Report& report) {
    std::ofstream file(path, std::ios::binary);
    file << bench::report_svg(report);
    if (!file.flush()) {
        print_error(
            "{}: cannot be written; check that its folder exists and the disk is not full\n", path);
        return false;
    }
    return true;
}

std::size_t report_columns() {
    constexpr std::size_t kUsual = 80;
    return std::min(terminal_columns().value_or(kUsual), kMostColumns);
}

/// Shows the running measurement; on a terminal only.
void show_progress(std::string_view text) {
    if (::isatty(STDERR_FILENO) == 1) {
        print_error("\r\x1b[K{}", text);
        std::fflush(stderr);
    }
}

tl::expected<Report, std::string> measure(const BenchSettings& settings,
                                          const std::vector<BenchPart>& parts) {
    Report report;
    report.missing = missing_realtime();
    const bench::AwakeProcessors awake;
    if (!awake.held()) {
        report.missing.emplace_back(
            "the processors are not kept awake (/dev/cpu_dma_latency), so every wake-up takes "
            "longer; run as root");
    }
    double shares = 0;
    for (const BenchPart& part : parts) {
        shares += part.share;
    }
    for (const BenchPart& part : parts) {
        const auto length =
            std::chrono::duration_cast<Duration>(settings.length * part.share / shares);
        show_progress(fmt::format("measuring {} ...", part.name));
        auto measured = part.add(report, settings, length);
        show_progress("");
        if (bench::interrupted()) {
            return report;
        }
        if (!measured) {
            return tl::unexpected(fmt::format("{}: {}", part.name, measured.error()));
        }
    }
    return report;
}

int run_bench(const BenchOptions& options) {
    const auto parts = chosen_parts(options);
    if (!parts) {
        return complain(parts.error(), kExitWrongUse);
    }
    auto settings = settings_of(options, *parts);
    if (!settings) {
        return complain(settings.error(), kExitWrongUse);
    }
    bench::watch_for_interruption();
    if (bench::realtime_permitted(kPriority)) {
        settings->priority = kPriority;
    }
    const auto report = measure(*settings, *parts);
    if (!report) {
        return complain(report.error(), kExitFailed);
    }
    if (bench::interrupted()) {
        return complain("interrupted", kExitInterrupted);
    }
    fmt::print("{}", options.format == "json" ? bench::report_json(*report)
                                              : bench::report_text(*report, report_columns()));
    std::fflush(stdout);
    if (!options.plot.empty() && !write_plot(options.plot, *report)) {
        return kExitFailed;
    }
    return report->broken.empty() ? kExitFine : kExitFailed;
}

constexpr const char* kNotes =
    "Each measurement is shown beside the same without tribus:\n"
    "  latency   i.Bus frames of 18 channels through `tribus run` over pseudo-terminals, from the "
    "write to the read of the last byte, beside a relay that only waits, reads and writes, with "
    "the same priority. With --ports the frames are written on OUT, go over your wire (115200 "
    "baud, 2.8 ms) and come in on IN: until the engine writes its frame, beside a reader that "
    "only waits and reads.\n"
    "  lateness  of an output with schedule \"grid\" against its deadline, beside a thread that "
    "only sleeps until absolute instants\n"
    "  age       from the arrival of values to their first frame, for the schedules follow and "
    "grid locked, beside a writer that runs free\n"
    "  codecs    processor time for one frame of all channels\n"
    "  capacity  processor time a frame with 1 and 64 pipelines, beside the bare relay\n"
    "  ppm       with --line: how far the pulses of a receiver whose sticks rest are from the "
    "middle of their channel, by the kernel's time stamps, beside the clock that a reader reads "
    "when it wakes\n"
    "--require p99=200us: the latency of tribus, whole, as in the table; p50, p90 or p99. With "
    "added- in front (added-p50=20us) it is what tribus adds: its percentile minus that of the "
    "bare relay or reader.";

}  // namespace

Command bench_command() {
    auto options = std::make_shared<BenchOptions>();
    return {
        .name = "bench",
        .help = "Measure what tribus adds: latency, lateness, age, processor time",
        .notes = kNotes,
        .options = {{.name = "--seconds",
                     .value = &options->seconds,
                     .help = "Time of all measurements together",
                     .shows_value = true,
                     .range = {{0.5, 86400}},
                     .value_name = "SECONDS"},
                    {.name = "--ports",
                     .value = &options->ports,
                     .help = "Two real serial ports, TX of OUT connected to RX of IN",
                     .value_name = "IN OUT",
                     .count = 2},
                    {.name = "--line",
                     .value = &options->line,
                     .help = "GPIO line with the PPM of a receiver at rest, for ppm",
                     .value_name = "LINE"},
                    {.name = "--only",
                     .value = &options->only,
                     .help = "Some of latency,lateness,age,codecs,capacity,ppm",
                     .value_name = "LIST",
                     .delimiter = ','},
                    {.name = "--require",
                     .value = &options->require,
                     .help = "Fail if the latency is higher, such as p99=200us",
                     .value_name = "PERCENTILE=TIME"},
                    {.name = "--plot",
                     .value = &options->plot,
                     .help = "Draw the distributions into this SVG file",
                     .value_name = "FILE"},
                    {.name = "--format",
                     .value = &options->format,
                     .help = "json: one object",
                     .shows_value = true,
                     .choices = {"text", "json"}}},
        .examples = {{"sudo tribus bench", "all of it, 20 s"},
                     {"sudo tribus bench --only latency --seconds 5 --require p99=200us", ""},
                     {"sudo tribus bench --ports /dev/ttyAMA5 /dev/ttyAMA3 --plot bench.svg", ""}},
        .exits = {{kExitFailed, "not measured, or a requirement does not hold"},
                  {kExitInterrupted, "interrupted"}},
        .run = [options] { return run_bench(*options); },
    };
}

}  // namespace tribus
