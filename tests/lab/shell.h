#pragma once

#include <filesystem>
#include <string>

namespace tribus::test {

struct ShellResult {
    int status = 0;      ///< 128 plus the number if a signal ended it
    std::string output;  ///< both streams
};

/// Runs a command line with /bin/sh and waits for it, at most three minutes.
ShellResult run_shell(const std::string& command);

/// Runs a command that must succeed, or the test fails. Returns its output.
std::string shell(const std::string& command);

/// Ends a test that runs on a host's own kernel instead of in a guest of the laboratory. It prints
/// words that groups.cmake looks for, so that the test counts as skipped there.
void require_guest();

/// Writes `text` into a file of the kernel, such as one under /sys. The test fails if that fails.
void write_kernel_file(const std::filesystem::path& path, const std::string& text);

/// Returns the content of a file without the last line end, or an empty text if there is no file.
std::string read_file(const std::filesystem::path& path);

}  // namespace tribus::test
