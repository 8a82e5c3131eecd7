#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "core/time.h"
#include "pipelines/realtime/capture_ring.h"

/// Recordings of the flight recorder on disk.
namespace tribus {

/// One port and the names of its two files.
struct RecordedPort {
    const CaptureRing* ring = nullptr;
    bool can = false;
    std::string device;    ///< path or interface name
    Duration byte_time{};  ///< serial only
    std::string read_file;
    std::string written_file;
    std::string ring_file;  ///< file that holds its ring and survives a crash; may be empty
};

/// A small file that belongs to a recording: the configuration, or a file that it names.
struct SideFile {
    std::string name;
    std::string content;
};

/// Describes one recording folder. The texts are for the person who finds it.
struct RecordingOrder {
    std::filesystem::path directory;
    std::string kind;      ///< such as "failsafe"; part of the folder's name
    std::string reason;    ///< a sentence
    Instant zero{};        ///< begin of the recording; earlier pieces are left out
    Instant end = kNever;  ///< later pieces are damaged
    Duration zero_wall{};
    Duration event_wall{};  ///< for the folder's name; since 1970
    std::vector<RecordedPort> ports;
    std::vector<SideFile> files;
    std::string replay;  ///< command that runs the configuration over the recording again
    /// For each port that is not recorded: `/dev/ttyAMA3: why`.
    std::vector<std::string> lacks;
    std::size_t keep = 0;
    std::uintmax_t space = 0;  ///< upper limit in bytes of all recordings
};

/// Writes a recording: first under another name, so that a recording is complete or absent. Then
/// removes the oldest recordings beyond `keep` and `space`. Blocks as long as the disk does. On an
/// error, a sentence, it leaves nothing behind.
tl::expected<std::filesystem::path, std::string> write_recording(const RecordingOrder& order);

/// Removes unfinished recordings of processes that ended. Ignores errors.
void remove_unfinished_recordings(const std::filesystem::path& directory);

/// `2026-11-22T12-00-05Z`: the alphabetical order is the order of time. Pure.
std::string recording_time(Duration wall_time);

/// How long ago the latest recording of that kind was written; nothing if there is none.
std::optional<Duration> age_of_latest(const std::filesystem::path& directory,
                                      const std::string& kind, Duration wall_now);

}  // namespace tribus
