#pragma once

#include <stdlib.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

/// The built program, as a shell starts it. Needs the compile definition TRIBUS_PROGRAM.
namespace tribus::test {

struct Ended {
    int status = -1;
    std::string output;
};

/// `command` is shell text in which $TRIBUS is the program; errors are part of the output.
inline Ended run_in_shell(const std::string& command) {
    const std::string script = "exec 2>&1; TRIBUS='" TRIBUS_PROGRAM "'; " + command;
    std::FILE* const pipe = ::popen(script.c_str(), "r");
    Ended result;
    std::array<char, 4096> buffer{};
    while (pipe != nullptr && std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) {
        result.output += buffer.data();
    }
    const int status = pipe == nullptr ? -1 : ::pclose(pipe);
    result.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return result;
}

/// A folder that goes with its content.
class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::string name = std::filesystem::temp_directory_path() / "tribus-test-XXXXXX";
        path_ = ::mkdtemp(name.data()) == nullptr ? std::filesystem::path()
                                                  : std::filesystem::path(name);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }

    std::string path(const std::string& name) const { return path_ / name; }
    std::string write(const std::string& name, const std::string& content) const {
        std::ofstream(path(name), std::ios::binary) << content;
        return path(name);
    }
    std::string read(const std::string& name) const {
        std::ostringstream content;
        content << std::ifstream(path(name), std::ios::binary).rdbuf();
        return content.str();
    }

  private:
    std::filesystem::path path_;
};

}  // namespace tribus::test
