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

/// One port, and what its two files are called.
struct RecordedPort {
    const CaptureRing* ring = nullptr;
    bool can = false;
    std::string device;    ///< path, or interface
    Duration byte_time{};  ///< serial only
    std::string read_file;
    std::string written_file;
    std::string ring_file;  ///< where its ring is a file that outlives a crash
};

/// A small file that belongs to a recording: its configuration, and what that names.
struct SideFile {
    std::string name;
    std::string content;
};

/// What is to become one folder. All text is for the person who finds it.
struct RecordingOrder {
    std::filesystem::path directory;
    std::string kind;      ///< "failsafe": part of the folder's name
    std::string reason;    ///< a sentence
    Instant zero{};        ///< what came before is left out
    Instant end = kNever;  ///< what claims to be later is damaged
    Duration zero_wall{};
    Duration event_wall{};  ///< for the name; since 1970
    std::vector<RecordedPort> ports;
    std::vector<SideFile> files;
    std::string replay;  ///< the command that runs the configuration over it again
    /// `/dev/ttyAMA3: why`, of each port that is not recorded.
    std::vector<std::string> lacks;
    std::size_t keep = 0;
    std::uintmax_t space = 0;  ///< bytes of all recordings
};

/// Writes it: under another name first, so that a recording is whole or not there. Then removes the
/// oldest recordings beyond `keep` and `space`. Blocks as long as the disk does. The error is a
/// sentence, and nothing is left of the attempt.
tl::expected<std::filesystem::path, std::string> write_recording(const RecordingOrder& order);

/// Removes what an attempt left that ended with its process. Errors are of no interest.
void remove_unfinished_recordings(const std::filesystem::path& directory);

/// `2026-11-22T12-00-05Z`: in order of time where it is in order of letters. Pure.
std::string recording_time(Duration wall_time);

/// How long ago the latest recording of that kind was written; nothing where there is none.
std::optional<Duration> age_of_latest(const std::filesystem::path& directory,
                                      const std::string& kind, Duration wall_now);

}  // namespace tribus
