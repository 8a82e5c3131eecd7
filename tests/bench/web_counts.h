#pragma once

#include <cstddef>
#include <string>

#include <tl/expected.hpp>

/// The cost of pages that look: in the daemon, and in `tribus-web`. The errors say what went wrong.
namespace tribus::bench {

/// Upper limits. A figure depends a little on how the machine wakes the programs, so each is what
/// was measured plus 3 percent.
inline constexpr double kMostOfAnEvent = 10'450;
/// Bytes of the status that the event tells; the second is what was measured plus 3 percent. 330 of
/// them are the texts of an input and an output, implausible frames, what the output waits for,
/// whether its module is heard, all of them in one line, and what only the log told before:
/// absences, two senders, channels by preset, losses that were bridged, and for how long a state
/// has been so.
inline constexpr double kUsualStatusBytes = 2'341;
inline constexpr double kMostStatusBytes = 2'412;
inline constexpr double kMostOfAFurtherPage = 10'510;
/// Between two counts of the same in the daemon, as much as between its counts and their ceilings:
/// it wakes a little more or less often.
inline constexpr double kDaemonNoise = 0.06;
/// User instructions a second of the daemon's main thread while any number of pages looks.
inline constexpr double kMostOfMainThreadWithAWatcher = 3'980'000;
/// Resident memory of `tribus-web` with kManyPages pages, in bytes.
inline constexpr double kMostWebMemory = 12e6;
inline constexpr std::size_t kManyPages = 8;

struct PagesInDaemon {
    double data_thread_a_frame = 0;  ///< user instructions of all threads but the main thread
    double main_thread_a_second = 0;
};

/// Counts in the daemon while `pages` pages look at it through `tribus-web`; without any, that does
/// not run. Takes 15 s.
tl::expected<PagesInDaemon, std::string> daemon_with_pages(std::size_t pages);

struct WebInstructions {
    double an_event = 0;    ///< user instructions of the program for each status that one page gets
    std::size_t bytes = 0;  ///< of a status
};

/// Counts in `tribus-web` while `pages` pages look at one daemon. Takes 15 s.
tl::expected<WebInstructions, std::string> web_with_pages(std::size_t pages);

/// Resident bytes of `tribus-web` after so many pages have looked for some seconds.
tl::expected<double, std::string> web_memory(std::size_t pages);

}  // namespace tribus::bench
