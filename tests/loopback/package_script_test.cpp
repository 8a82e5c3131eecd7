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

/// Installs a package that is missing, with an apt-get that says of `update` what a shell's text
/// does. Nothing sleeps.
Ended installed_where_update(const std::string& text) {
    return run_in_shell(
        "folder=$(mktemp -d); export folder; cd '" TRIBUS_SOURCE_DIR
        "'; "
        "put() { { echo '#!/bin/sh'; cat; } >$folder/$1; chmod 755 $folder/$1; }; "
        "put apt-get <<'END'\n"
        "[ \"$2\" = update ] || { echo apt-get $*; exit; }\n"
        "echo . >>$folder/updates; updates=$(wc -l <$folder/updates)\n" +
        text +
        "\nEND\nput sudo <<'END'\nexec \"$@\"\nEND\n"
        "put sleep </dev/null; echo exit 1 | put dpkg-query; "
        "PATH=$folder:$PATH sh -c '. deploy/prepare.sh; install_packages hello'; status=$?; "
        "rm -r $folder; exit $status");
}

constexpr const char* kLocked =
    "echo 'E: Could not get lock /var/lib/apt/lists/lock. It is held by process 7 (apt-get)'; "
    "exit 100";

TEST(InstallPackages, WaitsForAnotherProgramThatUsesApt) {
    const Ended ended =
        installed_where_update(std::string("[ $updates -gt 3 ] || { ") + kLocked + "; }");
    EXPECT_EQ(ended.status, 0) << ended.output;
    const std::string waits =
        "Waiting for another program that uses apt: E: Could not get lock "
        "/var/lib/apt/lists/lock. It is held by process 7 (apt-get)\n";
    EXPECT_NE(ended.output.find(waits), std::string::npos) << ended.output;
    EXPECT_EQ(ended.output.find(waits), ended.output.rfind("Waiting")) << "once: " << ended.output;
    EXPECT_NE(ended.output.find("apt-get -q -o DPkg::Lock::Timeout=600 install --yes "
                                "--no-install-recommends hello\n"),
              std::string::npos)
        << ended.output;
}

TEST(InstallPackages, SaysWhoKeepsAptLockedForTooLong) {
    const Ended ended = installed_where_update(kLocked);
    EXPECT_NE(ended.status, 0);
    EXPECT_NE(ended.output.rfind("\nE: Could not get lock"), std::string::npos) << ended.output;
    EXPECT_EQ(ended.output.find("apt-get -q"), std::string::npos) << "it installs nothing";
}

TEST(InstallPackages, DoesNotWaitWhereAptFailsForAnotherReason) {
    const Ended ended = installed_where_update("echo 'E: no net'; exit 100");
    EXPECT_NE(ended.status, 0);
    EXPECT_EQ(ended.output, "Installing Debian packages: hello\nE: no net\n");
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

TEST(Repack, HasAChangelogOfTheVersionsOfChangelogMd) {
    if (run_in_shell("dpkg-deb --version && gzip --version").status != 0) {
        GTEST_SKIP() << "a guest with the processor of a board has no dpkg-deb";
    }
    const std::string pages = "one/usr/share/doc/one/";
    const Ended ended = run_in_shell(
        "set -e; folder=$(mktemp -d); cd \"$folder\"; export SOURCE_DATE_EPOCH=1000000000; "
        "mkdir -p one/DEBIAN " +
        pages +
        "; chmod 755 one/DEBIAN; touch one/DEBIAN/md5sums; "
        "printf '## [Unreleased]\n\n- a\n\n## [1.1.0] - 2026-11-28\n\n## [1.0.0] - 2026-11-22\n' "
        ">" +
        pages +
        "CHANGELOG.md; for version in 1.2.0+deb13 1.1.0; do "
        "printf \"Package: one\nVersion: $version\nArchitecture: all\nInstalled-Size: 1\n"
        "Maintainer: A B <a@b.c>\nDescription: one\n\" >one/DEBIAN/control; "
        "dpkg-deb --root-owner-group -b one one.deb >/dev/null; "
        "'" TRIBUS_SOURCE_DIR
        "/deploy/debian/repack.sh' one.deb; rm -rf out; "
        "dpkg-deb -R one.deb out; zcat out/usr/share/doc/one/changelog.gz | grep -v '^$\\|\\*'; "
        "(cd out && md5sum --check --quiet DEBIAN/md5sums); done; rm -r \"$folder\"");
    EXPECT_EQ(ended.status, 0);
    const std::string releases =
        " -- A B <a@b.c>  Sat, 28 Nov 2026 00:00:00 +0000\n"
        "tribus (1.0.0) stable; urgency=medium\n"
        " -- A B <a@b.c>  Sun, 22 Nov 2026 00:00:00 +0000\n";
    EXPECT_EQ(ended.output,
              "tribus (1.2.0+deb13) UNRELEASED; urgency=medium\n"
              " -- A B <a@b.c>  Sun, 09 Sep 2001 01:46:40 +0000\n"
              "tribus (1.1.0) stable; urgency=medium\n" +
                  releases + "tribus (1.1.0) stable; urgency=medium\n" + releases);
}

TEST(Maintainer, IsWhoMakesThePackageElseTheAuthorOfTheCommit) {
    const std::string script = "'" TRIBUS_SOURCE_DIR "/deploy/debian/maintainer.sh'";
    EXPECT_EQ(run_in_shell("DEBFULLNAME='A B' DEBEMAIL=a@b.c " + script).output, "A B <a@b.c>\n");
    const Ended author = run_in_shell("git -C '" TRIBUS_SOURCE_DIR "' log -1 --format='%an <%ae>'");
    const Ended nobody = run_in_shell("unset DEBFULLNAME DEBEMAIL; " + script);
    if (author.status == 0) {
        EXPECT_EQ(nobody.output, author.output);
    } else {
        EXPECT_EQ(nobody.status, 1);
        EXPECT_NE(nobody.output.find("set DEBFULLNAME and DEBEMAIL"), std::string::npos);
    }
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
