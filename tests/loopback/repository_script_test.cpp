#include <string>

#include <gtest/gtest.h>

#include "tests/support/shell.h"

/// deploy/repository.sh: what it refuses, and the repository that it makes. tests/repository/run.sh
/// installs from one.
namespace tribus::test::repository_script_test {
namespace {

/// Runs `commands` in an empty folder, with an empty keyring and `repository`, the script.
Ended in_empty_folder(const std::string& commands) {
    return run_in_shell(
        "folder=$(mktemp -d); cd \"$folder\"; export GNUPGHOME=\"$folder/gnupg\"; "
        "mkdir -m 700 gnupg; repository() { sh '" TRIBUS_SOURCE_DIR
        "/deploy/repository.sh' \"$@\"; }\n" +
        commands +
        "\nstatus=$?; gpgconf --kill all 2>/dev/null; cd /; rm -r \"$folder\"; exit $status");
}

Ended repository_script(const std::string& before, const std::string& arguments) {
    return in_empty_folder(before + "\nrepository " + arguments);
}

/// Makes FILE, a package of these fields, with a file of that date.
std::string make_package(const std::string& file, const std::string& name,
                         const std::string& version, const std::string& processor = "amd64",
                         const std::string& date = "2026-11-01") {
    return "mkdir -p d/DEBIAN d/usr/bin; chmod 755 d/DEBIAN; echo " + version +
           " >d/usr/bin/one; find d/usr -exec touch -d '" + date +
           " UTC' {} +; printf 'Package: " + name + "\nVersion: " + version +
           "\nArchitecture: " + processor +
           "\nMaintainer: A B <a@b.c>\nDescription: one\n' >d/DEBIAN/control; "
           "SOURCE_DATE_EPOCH=$(date -d '" +
           date + " UTC' +%s) dpkg-deb --root-owner-group -b d " + file + " >/dev/null; ";
}

class RepositoryScript : public testing::Test {
  protected:
    void SetUp() override {
        if (run_in_shell("dpkg-deb --version && gpg --version && gpgv --version && "
                         "command -v gpg-agent && apt-ftparchive --version")
                .status != 0) {
            GTEST_SKIP() << "needs gpg, gpg-agent, gpgv and apt-ftparchive (apt-utils)";
        }
    }
};

TEST_F(RepositoryScript, SaysWhatIsMissing) {
    EXPECT_EQ(repository_script("", "").output,
              "deploy/repository.sh: needs a folder; --help says more\n");
    EXPECT_EQ(repository_script("", "").status, 2);
    EXPECT_EQ(repository_script("", "new --kye k").output,
              "deploy/repository.sh: knows no option --kye; --help says more\n");
    EXPECT_EQ(repository_script("mkdir full; touch full/file; touch a.deb", "full a.deb")
                      .output.find("/full has files, and is no repository: name a new folder\n") ==
                  std::string::npos,
              false);
    const auto says = [](const std::string& before, const std::string& arguments,
                         const std::string& words) {
        const Ended ended = repository_script(before, arguments);
        EXPECT_EQ(ended.status, 1);
        EXPECT_NE(ended.output.find(words), std::string::npos) << ended.output;
    };
    says("", "new none.deb", "/none.deb: there is no such file\n");
    says("echo >a.deb", "new a.deb", "/a.deb is no Debian package\n");
    says(make_package("a.deb", "other", "1"), "new a.deb",
         "/a.deb is the package other, not tribus\n");
    says(make_package("a.deb", "tribus", "1+deb14"), "new a.deb",
         "/a.deb is for none of these releases: bookworm trixie\n");
    says(make_package("a.deb", "tribus", "1", "riscv64"), "new a.deb",
         "/a.deb is for riscv64, not for one of: amd64 arm64 armhf\n");
    says(make_package("a.deb", "tribus", "1"), "new --key nobody a.deb",
         "your keyring has no secret key nobody; gpg --list-secret-keys lists those that it has\n");
}

TEST_F(RepositoryScript, MakesTheSameBytesOfTheSamePackages) {
    const Ended ended = in_empty_folder(
        make_package("tribus_1_amd64.deb", "tribus", "1") +
        make_package("tribus_1+deb13_arm64.deb", "tribus", "1+deb13", "arm64") +
        "repository first tribus_1_amd64.deb tribus_1+deb13_arm64.deb && cp -r first second && "
        "repository second second/pool/bookworm/tribus_1_amd64.deb && diff -r first second");
    EXPECT_EQ(ended.status, 0) << ended.output;
}

/// gpgv: the machine's clock may be set back between the script and the check.
TEST_F(RepositoryScript, TakesANewerPackageBesideTheOthersAndSignsAnew) {
    const Ended ended = in_empty_folder(
        make_package("tribus_1_amd64.deb", "tribus", "1") +
        make_package("tribus_1+deb13_arm64.deb", "tribus", "1+deb13", "arm64") +
        "repository new tribus_1_amd64.deb tribus_1+deb13_arm64.deb; " +
        make_package("tribus_2_amd64.deb", "tribus", "2") +
        "repository new tribus_2_amd64.deb && "
        "grep -h ^Version new/dists/*/main/*/Packages && "
        "gpgv --ignore-time-conflict --keyring ./new/tribus-archive-keyring.gpg "
        "new/dists/bookworm/InRelease && grep ^Architectures new/dists/bookworm/Release");
    EXPECT_EQ(ended.status, 0) << ended.output;
    for (const char* const words :
         {"Version: 1\nVersion: 2\nVersion: 1+deb13\n", "Good signature from \"tribus archive ",
          "Architectures: amd64 arm64 armhf\n"}) {
        EXPECT_NE(ended.output.find(words), std::string::npos) << ended.output;
    }
}

TEST_F(RepositoryScript, RefusesAChangedPackageOfTheSameVersion) {
    const Ended ended = in_empty_folder(
        make_package("tribus_1_amd64.deb", "tribus", "1") + "repository new tribus_1_amd64.deb; " +
        make_package("tribus_1_amd64.deb", "tribus", "1", "amd64", "2026-11-02") +
        "repository new tribus_1_amd64.deb");
    EXPECT_EQ(ended.status, 1) << ended.output;
    EXPECT_NE(ended.output.find("the repository has another tribus_1_amd64.deb: a changed package "
                                "needs a new version\n"),
              std::string::npos)
        << ended.output;
}

/// Otherwise boards keep the index that names the package.
TEST_F(RepositoryScript, HasALaterDateWhenAPackageIsTakenBack) {
    const std::string date =
        "$(date +%s --date=\"$(sed -n 's/^Date: //p' new/dists/bookworm/Release)\")";
    const Ended ended = in_empty_folder(
        make_package("tribus_1_amd64.deb", "tribus", "1") +
        make_package("tribus_2_amd64.deb", "tribus", "2", "amd64", "2100-01-01") +
        "repository new tribus_1_amd64.deb tribus_2_amd64.deb; echo first " + date +
        "; rm new/pool/bookworm/tribus_2_amd64.deb; repository new tribus_1_amd64.deb; "
        "echo then " +
        date);
    EXPECT_NE(ended.output.find("first 4102444800\n"), std::string::npos) << ended.output;
    EXPECT_NE(ended.output.find("then 4102444801\n"), std::string::npos) << ended.output;
}

TEST_F(RepositoryScript, LeavesTheRepositoryAsItWasIfItCannotSign) {
    const Ended ended =
        in_empty_folder(make_package("tribus_1_amd64.deb", "tribus", "1") +
                        make_package("tribus_2_amd64.deb", "tribus", "2") +
                        "repository new tribus_1_amd64.deb; cp -r new before; mkdir programs\n"
                        "cat >programs/gpg <<END\n"
                        "#!/bin/sh\n"
                        "case \"\\$*\" in *--detach-sign*) exit 2 ;; esac\n"
                        "exec $(command -v gpg) \"\\$@\"\n"
                        "END\n"
                        "chmod +x programs/gpg\n"
                        "PATH=$PWD/programs:$PATH repository new tribus_2_amd64.deb && exit 9\n"
                        "rm new/pool/bookworm/tribus_2_amd64.deb\n"
                        "diff -r before new && echo as it was");
    EXPECT_NE(ended.output.find("deploy/repository.sh: gpg cannot sign with "), std::string::npos)
        << ended.output;
    EXPECT_NE(ended.output.find("as it was\n"), std::string::npos) << ended.output;
}

TEST_F(RepositoryScript, KeepsItsKeyAndSaysWhereThatIsMissing) {
    const Ended ended =
        repository_script(make_package("tribus_1_amd64.deb", "tribus", "1") +
                              "repository new tribus_1_amd64.deb; gpgconf --kill all; rm -r "
                              "gnupg; mkdir -m 700 gnupg",
                          "new tribus_1_amd64.deb");
    EXPECT_EQ(ended.status, 1);
    EXPECT_NE(ended.output.find("whose secret part your keyring does not have: gpg --import it, or "
                                "name another by --key\n"),
              std::string::npos)
        << ended.output;
}

}  // namespace
}  // namespace tribus::test::repository_script_test
