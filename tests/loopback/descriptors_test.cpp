#include <csignal>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"

/// The daemon on a machine that gives it too few descriptors.
namespace tribus::test::descriptors_test {
namespace {

constexpr int kFewest = 4;  // standard streams and one more
constexpr int kEnough = 24;

class Descriptors : public Loopback {
  protected:
    /// `tribus run` with so many descriptors at most.
    Program limited(int most, const std::string& file) {
        return Program(folder(), {fmt::format("--nofile={}", most), TRIBUS_PROGRAM, "run", file},
                       {.executable = "/usr/bin/prlimit"});
    }
};

TEST_F(Descriptors, AreAskedForAtTheStartOrItEndsWithAnErrorThatSaysSo) {
    device("receiver");
    const std::string file = write_config(
        "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\n"
        "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
        "[output.servos]\nprotocol = \"sbus\"\naddress = \"127.0.0.1:5598\"\n");
    int ended = 0;
    int ran = 0;
    for (int most = kFewest; most <= kEnough; ++most) {
        Program program = limited(most, file);
        EXPECT_TRUE(eventually([&] {
            return !program.runs() || program.errors().find("started") != std::string::npos;
        })) << most;
        if (program.errors().find("loading shared libraries") != std::string::npos) {
            continue;  // not even the program itself could be opened
        }
        if (program.runs()) {
            program.signal(SIGTERM);
            EXPECT_EQ(program.end(), 0) << most << ": " << program.errors();
            ++ran;
        } else {
            EXPECT_EQ(program.end(), 1) << most << ": " << program.errors();
            EXPECT_NE(program.errors().find("Too many open files"), std::string::npos)
                << most << ": " << program.errors();
            ++ended;
        }
    }
    EXPECT_GT(ended, 0);
    EXPECT_GT(ran, 0);
}

}  // namespace
}  // namespace tribus::test::descriptors_test
