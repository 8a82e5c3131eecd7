#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/loopback/loopback.h"

/// The built program with a recorder, and what its recordings hold.
namespace tribus::test {

/// A folder in memory, like the runtime directory of a service.
class RuntimeFolder {
  public:
    RuntimeFolder() {
        std::string name = "/dev/shm/tribus-XXXXXX";
        path_ = ::mkdtemp(name.data());
    }
    RuntimeFolder(const RuntimeFolder&) = delete;
    RuntimeFolder& operator=(const RuntimeFolder&) = delete;
    ~RuntimeFolder() { std::filesystem::remove_all(path_); }
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

inline std::string content(const std::filesystem::path& path) {
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// A line of a recording with times.
struct RecordingLine {
    std::int64_t at_us = 0;
    std::string bytes;
};

inline std::vector<RecordingLine> timed_lines(const std::filesystem::path& path) {
    std::istringstream lines(content(path));
    std::vector<RecordingLine> found;
    for (std::string line; std::getline(lines, line);) {
        const std::size_t space = line.find(' ');
        if (line.starts_with('#') || space == std::string::npos) {
            continue;
        }
        found.push_back({std::stoll(line), line.substr(space + 1)});
    }
    return found;
}

/// The service of main_job() with [recorder].
class Recorded : public Loopback {
  protected:
    std::filesystem::path recordings() const { return folder() / "recordings"; }
    std::string config_with(const std::string& recorder, std::string_view input = kPatientInput) {
        return write_config(main_job(input, "", "[pipeline.main.failsafe]\nrecover = \"0s\"\n") +
                            "[recorder]\ndirectory = \"@recordings\"\n" + recorder);
    }
    Program& run_service(const std::string& config, std::size_t most_file_bytes = 0) {
        Program& program = start({"run", config}, {.most_file_bytes = most_file_bytes,
                                                   .runtime_directory = runtime_.path()});
        EXPECT_TRUE(program.says("started")) << program.errors();
        return program;
    }
    Program& request() {
        return start({"record", "--socket", (runtime_.path() / "control").string()});
    }
    std::vector<std::filesystem::path> found() const {
        std::vector<std::filesystem::path> folders;
        if (std::filesystem::exists(recordings())) {
            for (const auto& entry : std::filesystem::directory_iterator(recordings())) {
                folders.push_back(entry.path());
            }
        }
        std::sort(folders.begin(), folders.end());
        return folders;
    }
    /// Sends each value until the servos have it, and then for several of their periods: two values
    /// within one period would leave it to chance which one they get.
    bool drive(const std::vector<int>& firsts) {
        constexpr auto kLeast = std::chrono::milliseconds(40);
        return std::ranges::all_of(firsts, [&](int first) {
            Repeater repeater(receiver_, ibus_bytes(sticks_with_first(first)));
            const auto begin = Clock::now();
            bool seen = false;
            return eventually([&] {
                repeater.send_if_due();
                seen =
                    std::ranges::any_of(servos_.listen(),
                                        [&](const SbusSight& sight) {
                                            return sight.good() && sight.raw[0] == sbus_raw(first);
                                        }) ||
                    seen;
                return seen && Clock::now() - begin > kLeast;
            });
        });
    }

    RuntimeFolder runtime_;
    FarEnd& receiver_ = device("receiver");
    ServoBank servos_{device("servos")};
};

}  // namespace tribus::test
