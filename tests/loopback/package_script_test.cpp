#include <string>

#include <gtest/gtest.h>

#include "tests/support/shell.h"

/// What deploy/package.sh and release.sh say before they build anything, and how a package is
/// packed.
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

Ended release_script(const std::string& arguments) {
    return run_in_shell("sh '" TRIBUS_SOURCE_DIR "/deploy/release.sh' " + arguments);
}

TEST(ReleaseScript, RefusesAPackageThatItDoesNotKnow) {
    const Ended ended = release_script("arm64");
    EXPECT_EQ(ended.status, 2);
    EXPECT_EQ(ended.output,
              "deploy/release.sh: knows amd64-bookworm arm64-bookworm armhf-bookworm amd64-trixie "
              "arm64-trixie armhf-trixie, not arm64; --help says more\n");
}

TEST(ReleaseScript, ItsHelpBeginsWithTheChoices) {
    const Ended ended = release_script("--help");
    EXPECT_EQ(ended.status, 0);
    EXPECT_EQ(ended.output.substr(0, ended.output.find('\n')),
              "Usage: deploy/release.sh [--twice] [--tests] [PACKAGE...]");
}

/// A package as CPack makes it with this umask, whose folders have this size.
std::string packed(const std::string& name, const std::string& umask, int folder_kib) {
    return "mkdir " + name + "; (umask " + umask + "; mkdir -p " + name + "/DEBIAN " + name +
           "/usr/bin; echo one >" + name + "/usr/bin/one; chmod 644 " + name +
           "/usr/bin/one; printf 'Package: one\nVersion: 1\nArchitecture: all\nInstalled-Size: " +
           std::to_string(folder_kib) +
           "\nMaintainer: nobody <nobody@example.invalid>\nDescription: one\n' >" + name +
           "/DEBIAN/control; chmod 644 " + name + "/DEBIAN/control); chmod 755 " + name +
           "/DEBIAN; " + "dpkg-deb -Zgzip --root-owner-group -b " + name + " " + name +
           ".deb >/dev/null; ";
}

TEST(Repack, MakesTheSameBytesWhateverTheUmaskAndTheFileSystem) {
    if (run_in_shell("dpkg-deb --version").status != 0) {
        GTEST_SKIP() << "a guest with the processor of a board has no dpkg-deb";
    }
    const Ended ended = run_in_shell(
        "set -e; folder=$(mktemp -d); cd \"$folder\"; export SOURCE_DATE_EPOCH=1000000000; " +
        packed("first", "022", 12) + packed("second", "077", 48) +
        "cmp -s first.deb second.deb && echo 'they are the same before'; "
        "for each in first second; do '" TRIBUS_SOURCE_DIR
        "/deploy/debian/repack.sh' $each.deb; done; "
        "cmp first.deb second.deb; dpkg-deb -f first.deb Installed-Size; "
        "dpkg-deb -c first.deb | cut -c 1-10; rm -r \"$folder\"");
    EXPECT_EQ(ended.status, 0);
    // Two folders and a file.
    EXPECT_EQ(ended.output, "3\ndrwxr-xr-x\ndrwxr-xr-x\ndrwxr-xr-x\n-rw-r--r--\n");
}

}  // namespace
}  // namespace tribus::test::package_script_test
