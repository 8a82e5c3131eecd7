#include "tests/bench/codec_counts.h"

#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace tribus::bench {
namespace {

/// Returns the first number that `command` prints after `mark`, or the number of lines that start
/// with `mark`.
std::optional<std::uint64_t> run(const std::string& command, std::string_view mark, bool lines) {
    std::FILE* const pipe = ::popen((command + " 2>&1").c_str(), "r");
    if (pipe == nullptr) {
        return std::nullopt;
    }
    std::optional<std::uint64_t> found;
    std::array<char, 4096> buffer{};
    while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) {
        const std::string_view line(buffer.data());
        const std::size_t at = line.find(mark);
        if (at == line.npos) {
            continue;
        }
        found = lines ? found.value_or(0) + 1
                      : std::strtoull(line.data() + at + mark.size(), nullptr, 10);
    }
    const int status = ::pclose(pipe);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? found : std::nullopt;
}

bool can_run(const std::string& command) {
    return std::system((command + " > /dev/null 2>&1").c_str()) == 0;
}

std::string program_of(const Row& row) {
    switch (row.counted) {
        case Counted::engine:
            return TRIBUS_COUNT_ENGINE;
        case Counted::link:
            return TRIBUS_COUNT_LINK;
        case Counted::authenticated:
            return TRIBUS_COUNT_AUTHENTICATED;
        case Counted::codecs:
            break;
    }
    return TRIBUS_COUNT_CODECS;
}

/// The environment of a counted program. Functions of the C library take a longer way where a
/// variable stands near the end of a page, so the stack begins at the same address wherever the
/// program lies, whose path stands on it twice, and whatever the environment of the tests is. AES
/// is counted without the instructions that some processors have for it.
std::string same_stack(const std::string& program) {
    constexpr std::size_t kLongestPath = 512;
    const std::size_t padding = 2 * (kLongestPath - std::min(program.size(), kLongestPath));
    return "env -i NETTLE_FAT_OVERRIDE=none PADDING=" + std::string(padding, 'x') + " ";
}

std::optional<std::uint64_t> count(Machine machine, const Row& row, std::size_t units,
                                   std::size_t prepared) {
    const std::string work = std::string(row.workload) + " " + std::to_string(units) + " " +
                             std::to_string(prepared) + " '" + std::string(row.pattern) + "'";
    if (machine == Machine::x86) {
        return run(same_stack(program_of(row)) +
                       "\"$(command -v valgrind)\" --tool=callgrind "
                       "--callgrind-out-file=/dev/null " +
                       program_of(row) + " " + work,
                   "Collected : ", false);
    }
    return run("qemu-aarch64 -singlestep -d exec,nochain " TRIBUS_COUNT_CODECS_ARM " " + work,
               "Trace ", true);
}

}  // namespace

std::optional<double> cost(Machine machine, const Row& row, std::size_t from, std::size_t to,
                           std::size_t prepared) {
    const auto fewer = count(machine, row, from, prepared);
    const auto more = count(machine, row, to, prepared);
    if (!fewer || !more) {
        return std::nullopt;
    }
    return static_cast<double>(*more - *fewer) /
           static_cast<double>((to - from) * row.bytes_a_unit);
}

std::optional<double> cost(Machine machine, const Row& row) {
    return machine == Machine::x86 ? cost(machine, row, 200, 800, 1024)
                                   : cost(machine, row, 16, 64, 64);
}

std::optional<double> system_calls(const Row& row) {
    constexpr std::size_t kFew = 100;
    constexpr std::size_t kMany = 300;
    const auto calls = [&row](std::size_t units) {
        return run(program_of(row) + " " + std::string(row.workload) + " " + std::to_string(units),
                   "calls ", false);
    };
    const auto few = calls(kFew);
    const auto many = calls(kMany);
    if (!few || !many) {
        return std::nullopt;
    }
    return static_cast<double>(*many - *few) / static_cast<double>(kMany - kFew);
}

std::string missing(Machine machine) {
    if (machine == Machine::x86) {
        return can_run("valgrind --version") ? "" : "valgrind is not installed";
    }
    if (!can_run("qemu-aarch64 --version")) {
        return "qemu-aarch64 (package qemu-user) is not installed";
    }
    return can_run("test -x " TRIBUS_COUNT_CODECS_ARM)
               ? ""
               : "the workloads are not built for ARM: package g++-aarch64-linux-gnu";
}

}  // namespace tribus::bench
