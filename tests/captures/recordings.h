#pragma once

#include <filesystem>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "transports/recordings/recording.h"

/// Recordings of real receivers. Their licences differ, so they are not part of the project: each
/// test runs over the twins, and over the recordings too where their folder is (CMake variable
/// TRIBUS_SHARED). Files have the names that they have there: NAME.timed.txt, NAME.saleae.csv,
/// NAME.channels.csv.
namespace tribus::test {

enum class Capture { twin, recording };

/// Returns `twin`, and `recording` where the folder of the recordings is.
std::vector<Capture> captures();

/// Returns the folder of the recordings, which may be missing.
std::filesystem::path recordings_folder();

void PrintTo(Capture capture, std::ostream* text);

/// For INSTANTIATE_TEST_SUITE_P: the capture's name.
std::string capture_name(Capture capture);

/// Returns a file's content. The test fails if the folder of the recordings lacks the file.
std::string content_of(std::string_view file, Capture capture);

/// Returns a file for a program. A twin is written into `folder`.
std::filesystem::path file_of(std::string_view file, Capture capture,
                              const std::filesystem::path& folder);

/// Returns what a file holds; its name ends in .timed.txt or .saleae.csv.
Recording recording_of(std::string_view file, Capture capture);

/// Returns the single frames that public documents quote (tests/vectors/single_frames.txt).
Recording single_frames();

/// Returns the frames of a file whose name ends in .channels.csv, each with its channels in us.
std::vector<std::vector<int>> channel_rows(std::string_view file, Capture capture);

/// Returns the files of receivers that are not in the folder of the recordings.
std::vector<std::string> missing_recordings();

}  // namespace tribus::test
