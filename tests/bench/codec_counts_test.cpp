#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>

#include "tests/bench/codec_ceilings.h"

/// Instructions a frame of the codecs, as two processors execute them: exact, the same on every
/// machine, and so fit to fail a test. What is counted, and how, tells README.md beside this file.
namespace tribus::bench {

/// How googletest shows a row.
void PrintTo(const Row& row, std::ostream* out) {
    *out << row.name;
}

namespace {

enum class Machine : std::uint8_t { x86, arm };

bool on_ci() {
    const char* ci = std::getenv("CI");
    return ci != nullptr && std::string_view(ci) == "true";
}

/// The first number that `command` prints behind `mark`, or the number of lines that start with it.
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

std::optional<std::uint64_t> count(Machine machine, const Row& row, std::size_t units,
                                   std::size_t prepared) {
    const std::string work = std::string(row.workload) + " " + std::to_string(units) + " " +
                             std::to_string(prepared) + " '" + std::string(row.pattern) + "'";
    if (machine == Machine::x86) {
        return run("valgrind --tool=callgrind --callgrind-out-file=/dev/null " TRIBUS_COUNT_CODECS
                   " " +
                       work,
                   "Collected : ", false);
    }
    return run("qemu-aarch64 -singlestep -d exec,nochain " TRIBUS_COUNT_CODECS_ARM " " + work,
               "Trace ", true);
}

/// Instructions a frame, or a byte of garbage.
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

/// Why this machine cannot count; empty if it can.
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

class CodecCounts : public testing::TestWithParam<Row> {
  protected:
    /// On the build server nothing may be left out.
    static bool ready(Machine machine) {
        const std::string what = missing(machine);
        if (!what.empty() && on_ci()) {
            ADD_FAILURE() << what;
        }
        return what.empty();
    }
};

TEST_P(CodecCounts, StaysBelowItsCeilingOnX86) {
    if (!ready(Machine::x86)) {
        GTEST_SKIP() << missing(Machine::x86);
    }
    const auto measured = cost(Machine::x86, GetParam(), 500, 2000, 2048);
    ASSERT_TRUE(measured) << "the count went wrong";
    RecordProperty("instructions", std::to_string(*measured));
    EXPECT_LE(*measured, GetParam().most_x86);
}

TEST_P(CodecCounts, StaysBelowItsCeilingOnArm) {
    if (!ready(Machine::arm)) {
        GTEST_SKIP() << missing(Machine::arm);
    }
    const auto measured = cost(Machine::arm, GetParam(), 50, 250, 256);
    ASSERT_TRUE(measured) << "the count went wrong";
    RecordProperty("instructions", std::to_string(*measured));
    EXPECT_LE(*measured, GetParam().most_arm);
}

INSTANTIATE_TEST_SUITE_P(Frames, CodecCounts, testing::ValuesIn(kFrameRows),
                         [](const auto& row) { return std::string(row.param.name); });

class GarbageCounts : public CodecCounts {};

TEST_P(GarbageCounts, AreLinear) {
    if (!ready(Machine::x86)) {
        GTEST_SKIP() << missing(Machine::x86);
    }
    const auto first = cost(Machine::x86, GetParam(), 256, 512, 1024);
    const auto twice = cost(Machine::x86, GetParam(), 512, 1024, 1024);
    ASSERT_TRUE(first && twice) << "the count went wrong";
    EXPECT_NEAR(*twice, *first, 0.05 * *first);
}

INSTANTIATE_TEST_SUITE_P(Garbage, GarbageCounts, testing::ValuesIn(kGarbageRows),
                         [](const auto& row) { return std::string(row.param.name); });
INSTANTIATE_TEST_SUITE_P(Garbage, CodecCounts, testing::ValuesIn(kGarbageRows),
                         [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace tribus::bench
