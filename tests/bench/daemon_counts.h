#pragma once

#include <sys/types.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "tests/bench/lane.h"
#include "tests/bench/subject.h"

/// The cost of a frame in the whole program, `tribus run` with ptys. The errors say what went
/// wrong.
namespace tribus::bench {

/// Period of the receiver's frames in all counts.
inline constexpr auto kDaemonFramePeriod = std::chrono::microseconds(7700);

/// A workload of the program, with a rule for each channel, and the upper limit of its user
/// instructions a frame in all threads. The number of wake-ups differs a little from run to
/// run, so the limits have some room.
struct DaemonRow {
    std::string_view name;
    Carries carries = Carries::sbus;
    double most = 0;
};
inline constexpr std::array kDaemonRows{
    DaemonRow{"Ibus18ToSbus", Carries::sbus, 2490},
    DaemonRow{"Ibus14ToSbus", Carries::sbus_of_14, 2580},
    DaemonRow{"SbusToIbus18", Carries::ibus_of_sbus, 2490},
};
/// User instructions a second of the main thread, which looks at the devices five times a second.
/// Each look asks too what each output waits for and whether an input has frames that do not count.
inline constexpr double kMostOfMainThread = 29'000;
/// System calls of the data thread: a wait, a read, a question whether the port still has the frame
/// before, and a write; and some wake-ups for the figures.
inline constexpr double kMostCallsAFrame = 4.05;
inline constexpr double kLeastCallsAFrame = 3;
/// Memory of the program, all of it locked, in bytes; after a reload; of it that of no file; and
/// that of no file for each further pipeline. 0.5 KiB of the last are published of what its output
/// waits for and of frames that do not count.
inline constexpr double kMostMemory = 5.4e6;
inline constexpr double kMostMemoryAfterAReload = 7.0e6;
inline constexpr double kMostMemoryOfNoFile = 0.77e6;
inline constexpr double kMostMemoryOfAPipeline = 17 * 1024;

struct DaemonInstructions {
    double a_frame = 0;  ///< of all threads
    double a_second_of_main_thread = 0;
};

/// Counts with callgrind, one frame in 7.7 ms. Takes 9 s.
tl::expected<DaemonInstructions, std::string> daemon_instructions(Carries carries);

struct DaemonCalls {
    double a_frame = 0;
    std::string kinds;  ///< each call with its number, of all frames
    int frames = 0;
};

/// Counts the system calls of the data thread with strace. Takes 10 s.
tl::expected<DaemonCalls, std::string> daemon_calls(const ApplianceSettings& settings);

struct DaemonMemory {
    double one_pipeline = 0;    ///< bytes resident with one pipeline
    double after_a_reload = 0;  ///< bytes resident with it, 1.5 s after a reload
    double locked = 0;          ///< bytes of the first that are locked
    double of_no_file = 0;      ///< bytes of these that are of no file: heap, stacks, data
    /// Bytes of no file for each further pipeline, of 64. How much of the program's file is
    /// resident changes by 0.3 MB from start to start.
    double each_further = 0;
};

/// `settings` should demand real time, which locks the memory: all of it is then resident.
tl::expected<DaemonMemory, std::string> daemon_memory(const ApplianceSettings& settings);

/// The folder of the data thread in /proc. It is found by its name; empty if there is none.
std::filesystem::path data_thread(pid_t process);

/// The words before a program that count its instructions into files of a folder.
std::vector<std::string> under_callgrind(const std::filesystem::path& folder);
/// From the start of the program to its end.
struct CallgrindCounts {
    std::uint64_t all = 0;
    std::uint64_t main_thread = 0;
};
CallgrindCounts callgrind_counts(const std::filesystem::path& folder);

}  // namespace tribus::bench
