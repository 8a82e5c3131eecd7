#include "app/cli/new_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "app/cli/replace_file.h"
#include "app/client/draft.h"
#include "config/language/read_file.h"
#include "tests/support/temporary_folder.h"

/// Files in a folder of another user, who puts other things in their place.
namespace tribus::test::new_file_test {
namespace {

namespace fs = std::filesystem;

class NewFile : public testing::Test {
  protected:
    bool make(const std::string& name) const {
        const UniqueFd folder = folder_of(folder_ / name);
        const UniqueFd made = new_file(folder.get(), name, 0640);
        return made.valid() && write_all(made.get(), "new");
    }

    TemporaryFolder folder_;
};

TEST_F(NewFile, HasItsModeWhateverTheUmask) {
    const mode_t before = ::umask(0077);
    EXPECT_TRUE(make("a"));
    ::umask(before);
    struct stat told {};
    ASSERT_EQ(::stat((folder_ / "a").c_str(), &told), 0);
    EXPECT_EQ(told.st_mode & 07777U, 0640U);
}

TEST_F(NewFile, WaitsForNoReaderOfAPipe) {
    ASSERT_EQ(::mkfifo((folder_ / "a").c_str(), 0666), 0);
    EXPECT_TRUE(make("a"));
    EXPECT_EQ(folder_.read("a"), "new");
}

TEST_F(NewFile, TakesTheNameAndNotTheContentOfAnotherFile) {
    folder_.write("other", "of somebody else");
    fs::create_hard_link(folder_ / "other", folder_ / "a");
    EXPECT_TRUE(make("a"));
    EXPECT_EQ(folder_.read("other"), "of somebody else");
    EXPECT_EQ(folder_.read("a"), "new");
}

TEST_F(NewFile, IsNotWrittenWhereALinkLeads) {
    folder_.write("other", "of somebody else");
    fs::create_symlink(folder_ / "other", folder_ / "a");
    EXPECT_TRUE(make("a"));
    EXPECT_EQ(folder_.read("other"), "of somebody else");
    EXPECT_FALSE(fs::is_symlink(folder_ / "a"));
}

TEST_F(NewFile, BelongsToTheOwnerOfTheFolderIfRootMakesIt) {
    if (::geteuid() != 0) {
        GTEST_SKIP() << "only root gives files away";
    }
    constexpr uid_t kService = 65534;
    ASSERT_EQ(::chown(folder_.path().c_str(), kService, kService), 0);
    EXPECT_TRUE(make("a"));
    struct stat told {};
    ASSERT_EQ(::stat((folder_ / "a").c_str(), &told), 0);
    EXPECT_EQ(told.st_uid, kService);
    EXPECT_EQ(told.st_gid, kService);
}

/// The name of the file that is not finished yet is known.
TEST_F(NewFile, ReplacesAFileAlsoIfAnotherUserWaitsForIt) {
    folder_.write("a", "old");
    folder_.write("other", "of somebody else");
    fs::create_hard_link(folder_ / "other", folder_ / ".a.new");
    EXPECT_TRUE(replace_file(folder_ / "a", "new", 0600));
    ASSERT_EQ(::mkfifo((folder_ / ".a.new").c_str(), 0666), 0);
    EXPECT_TRUE(replace_file(folder_ / "a", "newer", 0600));
    EXPECT_EQ(folder_.read("a"), "newer");
    EXPECT_EQ(folder_.read("other"), "of somebody else");
}

TEST_F(NewFile, ADraftIsWrittenIntoItsFolderAndNowhereElse) {
    EXPECT_FALSE(write_draft(folder_ / "control", "text")) << "there is no folder yet";
    fs::create_directory(folder_ / "elsewhere");
    fs::create_symlink(folder_ / "elsewhere", folder_ / "draft");
    EXPECT_FALSE(write_draft(folder_ / "control", "text")) << "the folder is a link";
    EXPECT_TRUE(fs::is_empty(folder_ / "elsewhere"));
    fs::remove(folder_ / "draft");
    fs::create_directory(folder_ / "draft");
    fs::create_symlink(folder_ / "other", folder_ / "draft/draft.toml");
    EXPECT_TRUE(write_draft(folder_ / "control", "text"));
    EXPECT_EQ(folder_.read("draft/draft.toml"), "text");
    EXPECT_FALSE(fs::exists(folder_ / "other"));
}

/// A message about a draft shows its text, and the daemon may read what the writer may not.
TEST(ReadFile, FollowsNothingToADraft) {
    const TemporaryFolder folder;
    const std::string secret = folder.write("secret", "treasure");
    const auto read = [&] { return read_file(folder / "draft.toml", 100, FileKinds::draft); };
    fs::create_symlink(secret, folder / "draft.toml");
    ASSERT_FALSE(read());
    EXPECT_EQ(read().error(), "it is a symbolic link");
    fs::remove(folder / "draft.toml");
    fs::create_hard_link(secret, folder / "draft.toml");
    ASSERT_FALSE(read());
    EXPECT_EQ(read().error(), "it has another name too");
    fs::remove(folder / "draft.toml");
    ASSERT_EQ(::mkfifo((folder / "draft.toml").c_str(), 0666), 0);
    EXPECT_FALSE(read()) << "a pipe";
    fs::remove(folder / "draft.toml");
    folder.write("draft.toml", "text");
    EXPECT_EQ(read(), "text");
}

}  // namespace
}  // namespace tribus::test::new_file_test
