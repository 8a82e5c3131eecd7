#include "app/bench/bench.h"

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <memory>
#include <thread>

#include <fmt/format.h>

#include "app/bench/measurements.h"
#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "pipelines/realtime/scheduling.h"

namespace tribus {
namespace {

struct BenchOptions {
    double seconds = 20;
    std::vector<std::string> ports;
    std::vector<std::string> only;
    std::vector<std::string> require;
    std::string format = "text";

    bool wants(std::string_view name) const {
        return only.empty() || std::ranges::count(only, name) > 0;
    }
};

tl::expected<void, std::string> measure(bench::Report& report, const BenchOptions& options) {
    std::thread([&report] { report.missing = make_realtime({}).missing; }).join();
    const auto length =
        std::chrono::duration_cast<Duration>(std::chrono::duration<double>(options.seconds));
    const bool frames =
        options.wants("latency") || options.wants("cpu") || !options.require.empty();
    const bool lateness = options.wants("lateness");
    tl::expected<void, std::string> added;
    if (frames) {
        added = add_frames(report, options.ports, lateness ? length * 3 / 4 : length);
    }
    return added && lateness ? add_lateness(report, frames ? length / 4 : length) : added;
}

int run_bench(const BenchOptions& options) {
    std::vector<bench::Requirement> requirements;
    for (const std::string& text : options.require) {
        const auto requirement = bench::parse_requirement(text);
        if (!requirement) {
            return complain(requirement.error(), kExitWrongUse);
        }
        requirements.push_back(*requirement);
    }
    for (const int signal : {SIGINT, SIGTERM}) {
        std::signal(signal, [](int) {
            [[maybe_unused]] const auto said = ::write(STDERR_FILENO, "interrupted\n", 12);
            ::_exit(kExitInterrupted);
        });
    }
    bench::Report report;
    if (const auto measured = measure(report, options); !measured) {
        return complain(measured.error(), kExitFailed);
    }
    for (const bench::Requirement& requirement : requirements) {
        report.judge(requirement);
    }
    std::erase_if(report.measurements, [&](const auto& row) { return !options.wants(row.group); });
    fmt::print("{}", options.format == "json" ? report_json(report) : report_text(report));
    return report.broken.empty() ? kExitFine : kExitFailed;
}

constexpr const char* kNotes =
    "Each is shown beside the same without tribus:\n"
    "  latency   i.Bus frames of 18 channels over pseudo-terminals, from the write to the read of "
    "the last byte, beside a relay that only waits, reads and writes, with the same priority. With "
    "--ports the frames go out of OUT, over your wire (115200 baud, 2.8 ms) and come in on IN.\n"
    "  cpu       processor time of the thread that carries these frames, for a frame\n"
    "  lateness  of an output with schedule \"grid\", beside that of a thread that only sleeps\n"
    "--require p99=200us: the latency of tribus as in the table; p50, p90 or p99. With added- in "
    "front (added-p50=20us): what tribus adds, its percentile minus that of the bare relay.";

}  // namespace

Command bench_command() {
    auto options = std::make_shared<BenchOptions>();
    return {
        .name = "bench",
        .help = "Measure what tribus adds: latency, lateness, processor time",
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
                    {.name = "--only",
                     .value = &options->only,
                     .help = "Some of them, separated by commas",
                     .choices = {"latency", "lateness", "cpu"},
                     .delimiter = ','},
                    {.name = "--require",
                     .value = &options->require,
                     .help = "Fail if the latency is higher, such as p99=200us",
                     .value_name = "PERCENTILE=TIME"},
                    {.name = "--format",
                     .value = &options->format,
                     .help = "json: one object",
                     .shows_value = true,
                     .choices = {"text", "json"}}},
        .examples = {{"sudo tribus bench", "all of it, 20 s"},
                     {"sudo tribus bench --only latency --seconds 5 --require p99=200us", ""},
                     {"sudo tribus bench --ports /dev/ttyAMA5 /dev/ttyAMA3", ""}},
        .exits = {{kExitFailed, "not measured, or a requirement does not hold"},
                  {kExitInterrupted, "interrupted"}},
        .run = [options] { return run_bench(*options); },
    };
}

}  // namespace tribus
