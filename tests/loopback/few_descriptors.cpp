#include "tests/loopback/few_descriptors.h"

#include <csignal>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace tribus::test {
namespace {

constexpr int kFewest = 4;  // standard streams and one more
constexpr int kEnough = 32;

bool says_of(const Program& program, const char* part) {
    return program.errors().find(part) != std::string::npos;
}

}  // namespace

DescriptorTrials run_with_few_descriptors(const std::filesystem::path& folder,
                                          const std::string& file) {
    DescriptorTrials trials;
    for (int most = kFewest; most <= kEnough; ++most) {
        Program program(folder, {fmt::format("--nofile={}", most), TRIBUS_PROGRAM, "run", file},
                        {.executable = "/usr/bin/prlimit"});
        EXPECT_TRUE(eventually([&] { return !program.runs() || says_of(program, "started"); }))
            << most;
        if (says_of(program, "loading shared libraries")) {
            continue;  // not even the program itself could be opened
        }
        if (program.runs()) {
            program.signal(SIGTERM);
            EXPECT_EQ(program.end(), 0) << most << ": " << program.errors();
            EXPECT_FALSE(says_of(program, "waiting")) << most << ": " << program.errors();
            ++trials.ran;
        } else {
            EXPECT_EQ(program.end(), 1) << most << ": " << program.errors();
            EXPECT_TRUE(says_of(program, "Too many open files"))
                << most << ": " << program.errors();
            ++trials.ended;
        }
    }
    return trials;
}

}  // namespace tribus::test
