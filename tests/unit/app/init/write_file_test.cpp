#include "app/init/write_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <string>

#include "tests/support/temporary_folder.h"

namespace tribus::init::test::write_file_test {
namespace {

namespace fs = std::filesystem;
using tribus::test::TemporaryFolder;

std::ptrdiff_t files_in(const TemporaryFolder& folder) {
    return std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator());
}

TEST(InitFile, IsCompleteAndAlone) {
    const TemporaryFolder folder;
    const std::string path = folder / "rc.toml";
    EXPECT_EQ(file_problem(path, false), "");
    const auto written = write_file(path, "a = 1\n", false);
    EXPECT_TRUE(written) << written.error();
    EXPECT_EQ(folder.read("rc.toml"), "a = 1\n");
    EXPECT_EQ(files_in(folder), 1);
}

/// The service reads it as another user.
TEST(InitFile, CanBeReadByOthersAsTheUmaskAllows) {
    const TemporaryFolder folder;
    const mode_t before = ::umask(022);
    EXPECT_TRUE(write_file(folder / "rc.toml", "", false));
    ::umask(before);
    struct stat told {};
    ASSERT_EQ(::stat((folder / "rc.toml").c_str(), &told), 0);
    EXPECT_EQ(told.st_mode & 0777U, 0644U);
}

TEST(InitFile, ThatExistsIsNotReplaced) {
    const TemporaryFolder folder;
    const std::string path = folder.write("rc.toml", "mine");
    EXPECT_EQ(file_problem(path, false), path + " exists; --force replaces it");
    const auto written = write_file(path, "new", false);
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error(), path + " exists; --force replaces it");
    EXPECT_EQ(folder.read("rc.toml"), "mine");
    EXPECT_EQ(files_in(folder), 1);
}

TEST(InitFile, ThatIsALinkToNothingExists) {
    const TemporaryFolder folder;
    fs::create_symlink(folder / "nothing", folder / "rc.toml");
    EXPECT_NE(file_problem(folder / "rc.toml", false), "");
}

TEST(InitFile, IsReplacedOnRequestAndKeepsItsMode) {
    const TemporaryFolder folder;
    const std::string path = folder.write("rc.toml", "old");
    fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
    EXPECT_EQ(file_problem(path, true), "");
    const auto written = write_file(path, "new", true);
    EXPECT_TRUE(written) << written.error();
    EXPECT_EQ(folder.read("rc.toml"), "new");
    EXPECT_EQ(fs::status(path).permissions(),
              fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
    EXPECT_EQ(files_in(folder), 1);
}

TEST(InitFile, BehindALinkIsReplacedAndTheLinkStays) {
    const TemporaryFolder folder;
    folder.write("real.toml", "old");
    fs::create_symlink("real.toml", folder / "rc.toml");
    const auto written = write_file(folder / "rc.toml", "new", true);
    EXPECT_TRUE(written) << written.error();
    EXPECT_TRUE(fs::is_symlink(folder / "rc.toml"));
    EXPECT_EQ(folder.read("real.toml"), "new");
}

TEST(InitFile, MustBeARegularFile) {
    const TemporaryFolder folder;
    EXPECT_NE(file_problem(folder.path().string(), true).find("is not a regular file"),
              std::string::npos);
    EXPECT_NE(file_problem(folder.path().string(), false).find("is not a regular file"),
              std::string::npos);
    EXPECT_NE(file_problem("/dev/null", true).find("is not a regular file"), std::string::npos);
}

TEST(InitFile, NeedsAnExistingFolder) {
    const TemporaryFolder folder;
    EXPECT_NE(file_problem(folder / "none/rc.toml", false).find("No such file or directory"),
              std::string::npos);
    const auto written = write_file(folder / "none/rc.toml", "", false);
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().find("No such file or directory"), std::string::npos);
}

}  // namespace
}  // namespace tribus::init::test::write_file_test
