#pragma once

#include <filesystem>
#include <string>

namespace tribus::test {

struct ShellResult {
    int status = 0;      ///< 128 and the number if a signal ended it
    std::string output;  ///< both streams
};

/// Runs a command line of /bin/sh and waits for it, at most three minutes.
ShellResult run_shell(const std::string& command);

/// The same for a command that has to succeed, or else the test fails; its output.
std::string shell(const std::string& command);

/// Ends a test that runs on a host's own kernel instead of in a guest of the laboratory, with words
/// that groups.cmake looks for: there the test counts as skipped.
void require_guest();

/// Writes `text` into a file of the kernel, as under /sys; the test fails if it is not taken.
void write_kernel_file(const std::filesystem::path& path, const std::string& text);

/// What a file has, without the line end at its end; empty if there is none.
std::string read_file(const std::filesystem::path& path);

}  // namespace tribus::test
