#include "tests/captures/recordings.h"

#include <fstream>
#include <iterator>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/captures/receivers.h"
#include "tests/captures/twins.h"
#include "tests/support/vectors.h"

namespace tribus::test {
namespace {

const std::filesystem::path kFolder = std::filesystem::path(TRIBUS_SHARED_DIR) / "captures";

std::string read(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    EXPECT_TRUE(file) << path << " is missing";
    return {std::istreambuf_iterator<char>(file), {}};
}

Recording parsed(std::string_view content, std::string_view file) {
    auto recording = parse_recording(content, file);
    EXPECT_TRUE(recording) << recording.error();
    return recording ? *std::move(recording) : Recording{};
}

}  // namespace

std::vector<Capture> captures() {
    std::vector<Capture> all{Capture::twin};
    if (std::filesystem::is_directory(kFolder)) {
        all.push_back(Capture::recording);
    }
    return all;
}

std::filesystem::path recordings_folder() {
    return kFolder;
}

void PrintTo(Capture capture, std::ostream* text) {
    *text << capture_name(capture);
}

std::string capture_name(Capture capture) {
    return capture == Capture::twin ? "Twin" : "Recording";
}

std::string content_of(std::string_view file, Capture capture) {
    if (capture == Capture::recording) {
        return read(kFolder / file);
    }
    std::string twin = twin_file(file);
    EXPECT_FALSE(twin.empty()) << file << " has no twin";
    return twin;
}

std::filesystem::path file_of(std::string_view file, Capture capture,
                              const std::filesystem::path& folder) {
    if (capture == Capture::recording) {
        EXPECT_TRUE(std::filesystem::exists(kFolder / file)) << kFolder / file << " is missing";
        return kFolder / file;
    }
    std::ofstream(folder / file, std::ios::binary) << content_of(file, capture);
    return folder / file;
}

Recording recording_of(std::string_view file, Capture capture) {
    return parsed(content_of(file, capture), file);
}

Recording single_frames() {
    constexpr std::string_view kName = "single_frames.txt";
    return parsed(read(vector_file(kName)), kName);
}

std::vector<std::vector<int>> channel_rows(std::string_view file, Capture capture) {
    std::istringstream table(content_of(file, capture));
    std::vector<std::vector<int>> rows;
    std::string row;
    std::getline(table, row);
    while (std::getline(table, row)) {
        std::istringstream cells(row);
        auto& channels = rows.emplace_back();
        for (std::string cell; std::getline(cells, cell, ',');) {
            channels.push_back(std::stoi(cell));
        }
    }
    return rows;
}

std::vector<std::string> missing_recordings() {
    std::vector<std::string> missing;
    for (const Receiver& receiver : receivers()) {
        for (const std::string_view ending : receiver.endings) {
            const std::string file = std::string(receiver.name) + std::string(ending);
            if (!std::filesystem::exists(kFolder / file)) {
                missing.push_back(file);
            }
        }
    }
    return missing;
}

}  // namespace tribus::test
