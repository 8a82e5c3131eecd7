#include <string>

#include <gtest/gtest.h>

#include "tests/support/shell.h"

/// Messages of deploy/package.sh before it builds anything.
namespace tribus::test::package_script_test {
namespace {

Ended package_script(const std::string& arguments) {
    return run_in_shell("sh '" TRIBUS_SOURCE_DIR "/deploy/package.sh' " + arguments);
}

TEST(PackageScript, RefusesAProcessorThatItDoesNotKnow) {
    const Ended ended = package_script("mips");
    EXPECT_EQ(ended.status, 2);
    EXPECT_EQ(ended.output,
              "deploy/package.sh: knows amd64, arm64 and armhf, not mips; --help says more\n");
}

TEST(PackageScript, RefusesAReleaseThatItDoesNotKnow) {
    const Ended ended = package_script("arm64 --release sid");
    EXPECT_EQ(ended.status, 2);
    EXPECT_EQ(ended.output,
              "deploy/package.sh: --release is bookworm or trixie, not sid; --help says more\n");
}

TEST(PackageScript, RefusesAReleaseWithoutItsName) {
    const Ended ended = package_script("--release");
    EXPECT_EQ(ended.status, 2);
    EXPECT_EQ(ended.output,
              "deploy/package.sh: --release is bookworm or trixie; --help says more\n");
}

TEST(PackageScript, ItsHelpBeginsWithTheChoices) {
    const Ended ended = package_script("--help");
    EXPECT_EQ(ended.status, 0);
    EXPECT_EQ(ended.output.substr(0, ended.output.find('\n')),
              "Usage: deploy/package.sh [amd64|arm64|armhf] [--release bookworm|trixie] [--tests]");
}

}  // namespace
}  // namespace tribus::test::package_script_test
