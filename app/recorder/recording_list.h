#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

/// The recordings in a folder of the flight recorder, told by their names.
namespace tribus {

/// Length of a `recording_time`, with which each name begins.
inline constexpr std::size_t kRecordingTimeLength = std::string_view("2026-11-22T12-00-05Z").size();
/// Ends the name of a recording that is not written to its end.
inline constexpr std::string_view kUnfinishedEnding = ".unfinished";

/// Pure.
bool is_unfinished_recording(const std::string& name);
/// Number of a recording among those of the same second and kind; 1 for the first, whose name has
/// no number. Pure.
int number_of_recording(const std::string& name);

/// Folders of finished recordings, from the oldest to the newest. Ignores errors.
std::vector<std::filesystem::path> recordings_in(const std::filesystem::path& directory);
/// Bytes of its files.
std::uintmax_t size_of_recording(const std::filesystem::path& folder);

/// A recording as a list shows it.
struct ListedRecording {
    std::string name;   ///< of its folder
    std::string time;   ///< `2026-11-22T12:00:05Z`
    std::string cause;  ///< such as "failsafe"
    std::uintmax_t bytes = 0;
};
/// The newest first. Only folders of this very directory, with names of letters, digits, '-', '_'
/// and '.'; none that a symbolic link leads to. Empty if there is no such directory. The error is a
/// sentence.
tl::expected<std::vector<ListedRecording>, std::string> list_recordings(
    const std::filesystem::path& directory);

}  // namespace tribus
