#include "tests/loopback/few_descriptors.h"

#include <csignal>

#include <gtest/gtest.h>

namespace tribus::test {
namespace {

constexpr std::size_t kFewest = 4;  // standard streams and one more
constexpr std::size_t kEnough = 32;

bool says_of(const Program& program, const char* part) {
    return program.errors().find(part) != std::string::npos;
}

}  // namespace

DescriptorTrials run_with_few_descriptors(const std::filesystem::path& folder,
                                          const std::string& file) {
    DescriptorTrials trials;
    for (std::size_t most = kFewest; most <= kEnough; ++most) {
        Program program(folder, {"run", file}, {.most_descriptors = most});
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
