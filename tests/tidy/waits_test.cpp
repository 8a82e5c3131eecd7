#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

/// Tests of logic run in virtual time, so a busy machine cannot fail them. What needs a pty, a
/// thread or a clock of the machine is tested in tests/loopback.
namespace tribus::test::waits_test {
namespace {

namespace fs = std::filesystem;

/// What makes a test wait for the machine, and how it looks in a source.
const std::map<std::string, std::vector<std::string_view>>& machine() {
    static const std::map<std::string, std::vector<std::string_view>> kinds{
        {"sleep",
         {"sleep_for", "sleep_until", "usleep(", "::sleep(", "nanosleep", "seen_within",
          "epoll_wait", "epoll_pwait", "wait_for_events", "sleep 0", "sleep 1", "sleep 2",
          "sleep 3", "sleep 5", "sleep $"}},
        {"clock",
         {"monotonic_now", "awake_time_now", "wall_time_now", "steady_clock", "system_clock",
          "high_resolution_clock", "clock_gettime", "gettimeofday", "time(nullptr)", "timerfd_"}},
        {"pty", {"posix_openpt", "openpty", "forkpty", "ptmx", "far_end", "FarEnd", "--to pty"}},
        {"thread",
         {"std::thread", "std::jthread", "std::async", "this_thread", "condition_variable",
          "pthread_create", "start_thread(", "DataThread ", "GpioThread ", "GpioThread>",
          "LinkWorker ", "PwmLink::open", "Appliance::start", "FlightRecorder::make",
          "EpochFile::of"}},
    };
    return kinds;
}

bool is_in(const std::string& line, const std::vector<std::string_view>& words) {
    return std::ranges::any_of(
        words, [&](std::string_view word) { return line.find(word) != std::string::npos; });
}

/// `poll` that waits.
bool polls(const std::string& line) {
    return line.find("::poll(") != std::string::npos && line.find(", 0)") == std::string::npos;
}

/// Threads that keep no time: what two of them share, and the stack of one.
const std::set<std::string> kSubjectIsAThread{
    "tests/unit/config/language/depth_test.cpp",
    "tests/unit/pipelines/realtime/capture_ring_test.cpp",
    "tests/unit/pipelines/realtime/change_ring_test.cpp",
    "tests/unit/pipelines/realtime/scheduling_test.cpp",
    "tests/unit/pipelines/realtime/snapshot_test.cpp",
    "tests/unit/transports/links/start_thread_test.cpp",
};

/// Kinds by file, each with the first line in which it was found.
std::map<std::string, std::map<std::string, std::string>> found() {
    std::map<std::string, std::map<std::string, std::string>> all;
    const fs::path root = TRIBUS_SOURCE_DIR;
    for (const char* const folder : {"tests/unit", "tests/property", "tests/sim"}) {
        for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
            std::ifstream file(entry.path());
            const std::string name = entry.path().lexically_relative(root).string();
            const bool source = name.ends_with(".cpp") || name.ends_with(".h");
            for (std::string line; source && std::getline(file, line);) {
                for (const auto& [kind, words] : machine()) {
                    if (is_in(line, words) || (kind == "sleep" && polls(line))) {
                        all[name].emplace(kind, line);
                    }
                }
            }
        }
    }
    return all;
}

const std::map<std::string, std::map<std::string, std::string>>& all_found() {
    static const auto all = found();
    return all;
}

TEST(Tidy, WhatIsNoLoopbackTestWaitsForNothing) {
    for (const auto& [file, kinds] : all_found()) {
        for (const auto& [kind, line] : kinds) {
            EXPECT_TRUE(kind == "thread" && kSubjectIsAThread.contains(file))
                << file << ": a " << kind << ", which belongs into tests/loopback:\n"
                << line;
        }
    }
}

TEST(Tidy, WhatMayStartAThreadDoes) {
    for (const std::string& file : kSubjectIsAThread) {
        EXPECT_TRUE(all_found().contains(file)) << file;
    }
}

}  // namespace
}  // namespace tribus::test::waits_test
