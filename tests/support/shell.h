#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

#include "tests/support/temporary_folder.h"

/// Runs the built program from a shell. Needs the compile definition TRIBUS_PROGRAM.
namespace tribus::test {

struct Ended {
    int status = -1;
    std::string output;
};

/// Runs shell text in which $TRIBUS is the program. The output includes standard error.
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

}  // namespace tribus::test
