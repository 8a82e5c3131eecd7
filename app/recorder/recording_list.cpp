#include "app/recorder/recording_list.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <iterator>
#include <system_error>
#include <tuple>

#include <fmt/format.h>

#include "app/cli/plain_name.h"

namespace tribus {
namespace {

namespace fs = std::filesystem;

bool is_recording(const std::string& name) {
    return name.size() > kRecordingTimeLength + 1 && name[kRecordingTimeLength] == '-' &&
           name[kRecordingTimeLength - 1] == 'Z' &&
           std::isdigit(static_cast<unsigned char>(name[0])) != 0;
}

/// `2026-11-22T12:00:05Z`, of a name that begins with `2026-11-22T12-00-05Z`.
std::string iso_time(const std::string& name) {
    std::string time = name.substr(0, kRecordingTimeLength);
    constexpr std::size_t kHourEnd = 13;
    constexpr std::size_t kMinuteEnd = 16;
    time[kHourEnd] = ':';
    time[kMinuteEnd] = ':';
    return time;
}

ListedRecording listed(const fs::path& folder) {
    const std::string name = folder.filename().string();
    const std::string cause = name.substr(kRecordingTimeLength + 1);
    return {.name = name,
            .time = iso_time(name),
            .cause = cause.substr(0, cause.find('-')),
            .bytes = size_of_recording(folder)};
}

}  // namespace

bool is_unfinished_recording(const std::string& name) {
    return is_recording(name) && name.ends_with(kUnfinishedEnding);
}

int number_of_recording(const std::string& name) {
    const std::size_t dash = name.rfind('-');
    int number = 1;
    // A folder that somebody else named like ours may have any number.
    constexpr std::size_t kMostDigits = 9;
    const std::size_t digits = std::min(name.size() - dash - 1, kMostDigits);
    std::from_chars(name.data() + dash + 1, name.data() + dash + 1 + digits, number);
    return number;
}

std::vector<fs::path> recordings_in(const fs::path& directory) {
    std::vector<fs::path> found;
    std::error_code error;
    for (fs::directory_iterator at(directory, error), end; !error && at != end;
         at.increment(error)) {
        const std::string name = at->path().filename().string();
        if (is_recording(name) && !is_unfinished_recording(name)) {
            found.push_back(at->path());
        }
    }
    std::ranges::sort(found, {}, [](const fs::path& path) {
        const std::string name = path.filename().string();
        return std::tuple(name.substr(0, kRecordingTimeLength), number_of_recording(name), name);
    });
    return found;
}

std::uintmax_t size_of_recording(const fs::path& folder) {
    std::uintmax_t size = 0;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        const std::uintmax_t file = at->file_size(error);
        size += error ? 0 : file;
    }
    return size;
}

tl::expected<std::vector<ListedRecording>, std::string> list_recordings(const fs::path& directory) {
    std::error_code error;
    const fs::directory_iterator readable(directory, error);
    if (error && error != std::errc::no_such_file_or_directory) {
        return tl::unexpected(fmt::format("{}: {}", directory.string(), error.message()));
    }
    std::vector<ListedRecording> list;
    for (const fs::path& folder : recordings_in(directory)) {
        const bool is_folder = fs::symlink_status(folder, error).type() == fs::file_type::directory;
        if (is_folder && is_plain_name(folder.filename().string())) {
            list.push_back(listed(folder));
        }
    }
    std::ranges::reverse(list);
    return list;
}

}  // namespace tribus
