#include <string>

#include <gtest/gtest.h>

#include "tests/support/pages.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

/// What app/build_facts.cmake writes into the programs of a commit.
namespace tribus::test::build_facts_test {
namespace {

/// A clone in which a file is committed.
class BuildFacts : public testing::Test {
  protected:
    void SetUp() override {
        if (run_in_shell("'" TRIBUS_CMAKE "' --version && git --version").status != 0) {
            GTEST_SKIP() << "needs cmake and git";
        }
        commit_ = here(
            "git init -q; echo one >file; mkdir -p inner; git add file; "
            "git -c user.name=a -c user.email=a@b commit -q -m one; git rev-parse HEAD");
        ASSERT_EQ(commit_.size(), 41U) << commit_;
    }

    std::string here(const std::string& command) const {
        return run_in_shell(
                   "unset TRIBUS_COMMIT $(git rev-parse --local-env-vars); "
                   "export GIT_CONFIG_GLOBAL=/dev/null GIT_CONFIG_NOSYSTEM=1; cd '" +
                   folder_.path().string() + "'; " + command)
            .output;
    }
    /// What is written for the sources in that folder.
    std::string written(const std::string& sources, const std::string& before = "") const {
        const std::string said =
            here(before + "'" TRIBUS_CMAKE "' -DVERSION=9.8.7 '-DHOW=GCC 1' -DSOURCES=\"$PWD/" +
                 sources + "\" -DWRITE=facts.cpp -P '" TRIBUS_SOURCE_DIR "/app/build_facts.cmake'");
        EXPECT_EQ(said, "");
        return text_of_file(folder_.path() / "facts.cpp");
    }
    static std::string facts(const std::string& commit) {
        return "return {.version = \"9.8.7\", .how = \"GCC 1\", .commit = \"" + commit + "\"};";
    }
    std::string short_commit() const { return commit_.substr(0, 12); }

  private:
    TemporaryFolder folder_;
    std::string commit_;
};

TEST_F(BuildFacts, NameTheCommitOfAClone) {
    EXPECT_NE(written(".").find(facts(short_commit())), std::string::npos) << written(".");
}

TEST_F(BuildFacts, SayThatTheFilesAreNotThoseOfTheCommit) {
    here("echo two >file");
    EXPECT_NE(written(".").find(facts(short_commit() + " with changes")), std::string::npos)
        << written(".");
}

/// A release is built in a folder without git inside of a clone, perhaps of another commit.
TEST_F(BuildFacts, NameNoCommitOfAFolderInAnotherClone) {
    EXPECT_NE(written("inner").find(facts("")), std::string::npos) << written("inner");
}

TEST_F(BuildFacts, TakeTheCommitFromTheScriptThatMakesAPackage) {
    EXPECT_NE(written("inner", "TRIBUS_COMMIT=0123456789abcdef0123456789abcdef01234567 ")
                  .find(facts("0123456789ab")),
              std::string::npos);
}

TEST_F(BuildFacts, AreNotWrittenAgainIfTheyAreTheSame) {
    written(".");
    const std::string time = here("touch -d 2001-01-01 facts.cpp; stat -c %Y facts.cpp");
    written(".");
    EXPECT_EQ(here("stat -c %Y facts.cpp"), time);
}

}  // namespace
}  // namespace tribus::test::build_facts_test
