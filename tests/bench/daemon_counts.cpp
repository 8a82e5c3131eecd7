#include "tests/bench/daemon_counts.h"

#include <sys/mman.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "pipelines/realtime/clock.h"
#include "tests/bench/latency.h"
#include "tests/bench/tester.h"
#include "tests/support/temporary_folder.h"

namespace tribus::bench {
namespace {

using Refused = tl::unexpected<std::string>;

tl::expected<CallgrindCounts, std::string> instructions_of_run(Carries carries,
                                                               std::uint64_t frames) {
    const test::TemporaryFolder folder;
    ApplianceSettings ours;
    ours.program = TRIBUS_PROGRAM;
    ours.carries = carries;
    ours.period = std::chrono::milliseconds(7);
    ours.in_front = under_callgrind(folder.path());
    auto subject = carrying(Subject::appliance(1, ours));
    if (!subject) {
        return Refused(subject.error());
    }
    const TesterPriority priority;
    drive(*subject, {.period = kDaemonFramePeriod, .rounds = frames});
    subject->process().end();
    const CallgrindCounts counted = callgrind_counts(folder.path());
    if (counted.main_thread == 0) {
        return Refused("callgrind counted nothing: " + subject->process().errors());
    }
    return counted;
}

/// Adds up the column "calls" in strace's table, and names the single calls.
DaemonCalls calls_of_table(const std::string& table) {
    DaemonCalls calls;
    std::istringstream lines(table);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        double share = 0;
        double seconds = 0;
        double each = 0;
        double count = 0;
        std::string name;
        if (words >> share >> seconds >> each >> count >> name) {
            // If there were errors, their column stands before the name.
            std::string last;
            name = words >> last ? last : name;
            if (name != "total") {
                calls.a_frame += count;
                calls.kinds += fmt::format("{}{} {}", calls.kinds.empty() ? "" : ", ", name, count);
            }
        }
    }
    return calls;
}

/// Counts while the data thread handles `frames` frames. `a_frame` is the sum of all.
tl::expected<DaemonCalls, std::string> calls_for(Subject& subject, int frames) {
    const int table = ::memfd_create("calls", 0);
    const std::string thread = data_thread(subject.process().id()).filename();
    auto tracer = Process::execute(
        {"strace", "-c", "-p", thread, "-o", fmt::format("/proc/self/fd/{}", table)}, {table});
    if (!tracer) {
        return Refused(tracer.error());
    }
    sleep_until(monotonic_now() + std::chrono::milliseconds(500));
    Instant next = monotonic_now();
    for (int i = 0; i < frames && !interrupted(); ++i) {
        subject.lane().send();
        next += kFramePeriod;
        sleep_until(next);
        subject.lane().drain();
        subject.drain_further_outputs();
    }
    tracer->end();
    std::string text(1 << 16, '\0');
    const ssize_t count = ::pread(table, text.data(), text.size(), 0);
    ::close(table);
    text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    if (text.empty()) {
        return Refused("strace told nothing: " + tracer->errors());
    }
    DaemonCalls calls = calls_of_table(text);
    calls.frames = frames;
    return calls;
}

}  // namespace

std::vector<std::string> under_callgrind(const std::filesystem::path& folder) {
    return {"valgrind", "--tool=callgrind", "--separate-threads=yes",
            "--callgrind-out-file=" + (folder / "counts").string()};
}

CallgrindCounts callgrind_counts(const std::filesystem::path& folder) {
    constexpr std::string_view kMark = "\ntotals: ";
    CallgrindCounts counts;
    for (const auto& file : std::filesystem::directory_iterator(folder)) {
        // Each thread has a file, which ends with its sum.
        const std::string text = content_of(file.path());
        const std::size_t at = text.rfind(kMark);
        const std::uint64_t sum =
            at == text.npos ? 0 : std::strtoull(text.c_str() + at + kMark.size(), nullptr, 10);
        counts.all += sum;
        counts.main_thread += file.path().filename() == "counts-01" ? sum : 0;
    }
    return counts;
}

std::filesystem::path data_thread(pid_t process) {
    const std::filesystem::path tasks = fmt::format("/proc/{}/task", process);
    for (const auto& task : std::filesystem::directory_iterator(tasks)) {
        if (content_of(task.path() / "comm") == "tribus-data\n") {
            return task.path();
        }
    }
    return {};
}

tl::expected<DaemonInstructions, std::string> daemon_instructions(Carries carries) {
    constexpr std::uint64_t kFew = 200;
    constexpr std::uint64_t kMany = 700;
    const auto few = instructions_of_run(carries, kFew);
    const auto many = instructions_of_run(carries, kMany);
    if (!few || !many) {
        return Refused(few ? many.error() : few.error());
    }
    const std::chrono::duration<double> longer = kDaemonFramePeriod * (kMany - kFew);
    return DaemonInstructions{
        .a_frame = static_cast<double>(many->all - few->all) / static_cast<double>(kMany - kFew),
        .a_second_of_main_thread =
            static_cast<double>(many->main_thread - few->main_thread) / longer.count()};
}

tl::expected<DaemonCalls, std::string> daemon_calls(const ApplianceSettings& settings) {
    constexpr int kFew = 100;
    constexpr int kMany = 600;
    auto subject = carrying(Subject::appliance(1, settings));
    if (!subject) {
        return Refused(subject.error());
    }
    const auto few = calls_for(*subject, kFew);
    auto many = calls_for(*subject, kMany);
    if (!few || !many) {
        return Refused(few ? many.error() : few.error());
    }
    many->a_frame = (many->a_frame - few->a_frame) / (kMany - kFew);
    return many;
}

tl::expected<DaemonMemory, std::string> daemon_memory(const ApplianceSettings& settings) {
    constexpr std::size_t kMany = 64;
    std::array<ProcessUsage, 2> usage;
    ProcessUsage reloaded;
    for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
        auto subject = carrying(Subject::appliance(i == 0 ? 1 : kMany, settings));
        if (!subject) {
            return Refused(subject.error());
        }
        // The main thread too has run all that it runs while frames flow, and has dropped the rest.
        constexpr Duration kSettling = std::chrono::seconds(3);
        constexpr auto kRounds = static_cast<std::uint64_t>(kSettling / kFramePeriod);
        drive(*subject, {.rounds = kRounds});
        usage[i] = subject->usage().value_or(ProcessUsage{});
        if (i == 0) {
            ::kill(subject->process().id(), SIGHUP);
            drive(*subject, {.rounds = kRounds});
            if (subject->process().errors().find("reloaded") == std::string::npos) {
                return Refused("tribus run did not reload: " + subject->process().errors());
            }
            reloaded = subject->usage().value_or(ProcessUsage{});
        }
    }
    const auto anonymous = [&](std::size_t i) {
        return static_cast<double>(usage[i].anonymous_bytes);
    };
    return DaemonMemory{.one_pipeline = static_cast<double>(usage[0].resident_bytes),
                        .after_a_reload = static_cast<double>(reloaded.resident_bytes),
                        .locked = static_cast<double>(usage[0].locked_bytes),
                        .of_no_file = anonymous(0),
                        .each_further = (anonymous(1) - anonymous(0)) / (kMany - 1)};
}

}  // namespace tribus::bench
