#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <random>
#include <sstream>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "pipelines/realtime/clock.h"
#include "tests/bench/bound.h"
#include "tests/bench/daemon_counts.h"
#include "tests/bench/latency.h"
#include "tests/bench/subject.h"
#include "tests/bench/tester.h"

namespace tribus::test {
namespace {

using namespace bench;

Figures memory(const BoundSettings& settings) {
    const auto used = daemon_memory(appliance(settings));
    if (!used) {
        return Refused(used.error());
    }
    return std::vector<Figure>{{.row = "locked memory with one pipeline, MB",
                                .value = used->one_pipeline / 1e6,
                                .bound = 3.3,
                                .note = fmt::format("VmRSS, {:.2f} MB of no file; VmLck {:.1f} MB",
                                                    used->of_no_file / 1e6, used->locked / 1e6)},
                               {.row = "locked memory of each further pipeline, KiB",
                                .value = used->each_further / 1024,
                                .bound = 6,
                                .note = "of 64, memory of no file"}};
}

Figures lost_frames(const BoundSettings& settings) {
    constexpr std::size_t kLanes = 32;
    ApplianceSettings ours = appliance(settings);
    ours.period = std::chrono::milliseconds(3);
    auto subject = carrying(Subject::appliance(kLanes, ours));
    if (!subject) {
        return Refused(subject.error());
    }
    // A few frames more, because those of the warm-up do not count.
    const std::uint64_t frames = settings.all_frames ? 1'005'000 : 50'000;
    const TesterPriority priority;
    const LatencyResult result =
        drive(*subject, {.period = std::chrono::milliseconds(4), .rounds = frames / kLanes + 1});
    return std::vector<Figure>{
        {.row = "frames lost or torn",
         .value = static_cast<double>(result.lost + result.torn),
         .bound = 0,
         .note = fmt::format("of {}; latency p99 {} us, most {} us", result.latency.size(),
                             result.latency.percentile(99).count() / 1000,
                             result.latency.percentile(100).count() / 1000)}};
}

/// Returns the minor and major page faults of a process or thread, read from its `stat`.
std::uint64_t faults_of(const std::filesystem::path& stat) {
    std::string text = content_of(stat);
    text.erase(0, text.rfind(')') + 1);
    std::istringstream fields(text);
    std::string skipped;
    std::uint64_t minor = 0;
    std::uint64_t major = 0;
    for (int field = 3; field < 10; ++field) {
        fields >> skipped;
    }
    fields >> minor >> skipped >> major;
    return minor + major;
}

/// Sends frames, then nothing until the output is in failsafe, then garbage, then frames again.
void disturb(Lane& lane, std::mt19937& random) {
    constexpr int kFrames = 100;
    constexpr int kGarbageReads = 100;
    const auto step = [] { sleep_until(monotonic_now() + kFramePeriod); };
    for (int i = 0; i < kFrames && !interrupted(); ++i, step()) {
        lane.send();
        lane.drain();
    }
    sleep_until(monotonic_now() + std::chrono::milliseconds(1800));
    for (int i = 0; i < kGarbageReads && !interrupted(); ++i, step()) {
        lane.send_garbage(random() % 60 + 1, static_cast<std::uint32_t>(random()));
        lane.drain();
    }
    for (int i = 0; i < kFrames && !interrupted(); ++i, step()) {
        lane.send();
        lane.drain();
    }
}

Figures allocations(const BoundSettings& settings) {
    ApplianceSettings ours = appliance(settings);
    ours.environment = {"LD_PRELOAD=" + settings.heap_trap};
    auto subject = carrying(Subject::appliance(1, ours));
    if (!subject) {
        return Refused(subject.error());
    }
    std::mt19937 random(4);
    disturb(subject->lane(), random);
    const pid_t process = subject->process().id();
    const std::filesystem::path whole = fmt::format("/proc/{}", process);
    const std::filesystem::path thread = data_thread(process);
    const std::uint64_t whole_before = faults_of(whole / "stat");
    const std::uint64_t thread_before = faults_of(thread / "stat");
    for (int i = 0; i < 3; ++i) {
        disturb(subject->lane(), random);
    }
    const std::uint64_t thread_faults = faults_of(thread / "stat") - thread_before;
    const std::uint64_t whole_faults = faults_of(whole / "stat") - whole_before;
    const int status = subject->process().end();
    const std::string said = subject->process().errors();
    const bool watched = said.find("watched the data thread") != std::string::npos;
    if (!watched && said.find("allocated") == std::string::npos) {
        return Refused(fmt::format("the heap trap did not watch (status {}): {}", status, said));
    }
    return std::vector<Figure>{
        {.row = "heap allocations of the data thread after start",
         .value = watched ? 0.0 : 1.0,
         .bound = 0,
         .note = "dropouts and garbage included; the trap ends at the first"},
        {.row = "page faults of the data thread after start",
         .value = static_cast<double>(thread_faults),
         .bound = 0},
        {.row = "page faults of the process after start",
         .value = static_cast<double>(whole_faults),
         .bound = 0}};
}

Figures system_calls(const BoundSettings& settings) {
    std::vector<Figure> figures;
    double with_one_output = 0;
    for (const std::size_t outputs : {std::size_t{1}, std::size_t{2}}) {
        ApplianceSettings ours = appliance(settings);
        ours.outputs_per_input = outputs;
        const auto calls = daemon_calls(ours);
        if (!calls) {
            return Refused(calls.error());
        }
        const bool first = outputs == 1;
        figures.push_back({.row = first ? "system calls a frame" : "and for each further output",
                           .value = calls->a_frame - with_one_output,
                           .bound = first ? 3.0 : 1.0,
                           .allowance = 1.01,  // some wake-ups for the figures
                           .note = fmt::format("of {} frames: {}", calls->frames, calls->kinds)});
        with_one_output = calls->a_frame;
    }
    return figures;
}

}  // namespace

std::vector<Bound> count_bounds() {
    return {
        {"memory", "VmRSS of tribus run in real time", false, memory},
        {"heap", "allocations and page faults, with dropouts and garbage", false, allocations},
        {"calls", "system calls of the data thread", false, system_calls},
        {"lost", "frames lost or torn, 32 pipelines at 4 ms", false, lost_frames},
    };
}

}  // namespace tribus::test
