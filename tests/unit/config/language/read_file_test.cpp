#include "config/language/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"
#include "transports/links/unique_fd.h"

namespace tribus::test::read_file_test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMost = 1'000'000;

class ReadsFiles : public ::testing::Test {
  protected:
    std::string error(const std::string& path, FileKinds kinds = FileKinds::regular) const {
        const auto read = read_file(path, kMost, kinds);
        EXPECT_FALSE(read) << path;
        return read ? "" : read.error();
    }
    std::string pipe() const {
        EXPECT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
        return folder_ / "pipe";
    }
    const TemporaryFolder folder_;
};

TEST_F(ReadsFiles, Whole) {
    std::string content;
    for (int i = 0; content.size() < 200'000; ++i) {
        content += std::to_string(i) + '\0';
    }
    EXPECT_EQ(read_file(folder_.write("long", content), kMost), content);
    EXPECT_EQ(read_file(folder_.write("empty", ""), kMost), "");
}

TEST_F(ReadsFiles, UpToTheLimit) {
    const std::string path = folder_.write("file", "abcdef");
    EXPECT_EQ(read_file(path, 7), "abcdef");
    EXPECT_EQ(read_file(path, 6), "abcdef");
    EXPECT_EQ(read_file(path, 3), "abc");
    EXPECT_EQ(read_file(path, 0), "");
}

TEST_F(ReadsFiles, ThatLinksNameUnlessTheyAreDrafts) {
    const std::string path = folder_.write("file", "abc");
    fs::create_symlink(path, folder_ / "link");
    EXPECT_EQ(read_file(folder_ / "link", kMost), "abc");
    EXPECT_EQ(read_file(folder_ / "link", kMost, FileKinds::any), "abc");
    EXPECT_EQ(error(folder_ / "link", FileKinds::draft), "it is a symbolic link");
    fs::create_hard_link(path, folder_ / "other");
    EXPECT_EQ(read_file(path, kMost), "abc");
    EXPECT_EQ(error(path, FileKinds::draft), "it has another name too");
    EXPECT_EQ(read_file(folder_.write("alone", "d"), kMost, FileKinds::draft), "d");
}

TEST_F(ReadsFiles, NotIfALinkLeadsInACircle) {
    fs::create_symlink(folder_ / "circle", folder_ / "circle");
    EXPECT_EQ(error(folder_ / "circle"), "Too many levels of symbolic links");
}

TEST_F(ReadsFiles, NotIfTheyAreMissing) {
    EXPECT_EQ(error(folder_ / "none"), "No such file or directory");
    EXPECT_EQ(error(folder_ / "none", FileKinds::draft), "No such file or directory");
}

TEST_F(ReadsFiles, NotIfTheyAreFolders) {
    EXPECT_EQ(error(folder_ / ""), "it is a folder");
    EXPECT_EQ(error(folder_ / "", FileKinds::any), "it is a folder");
}

TEST_F(ReadsFiles, NotIfTheyArePipesAndDoesNotWait) {
    const std::string path = pipe();
    for (const FileKinds kinds : {FileKinds::regular, FileKinds::secret, FileKinds::draft}) {
        EXPECT_EQ(error(path, kinds), "it is a device or a pipe, not a file");
    }
}

TEST_F(ReadsFiles, WhichMayBePipesOrDevicesIfThatIsAllowed) {
    const std::string path = pipe();
    const UniqueFd writer(::open(path.c_str(), O_RDWR | O_CLOEXEC));
    ASSERT_EQ(::write(writer.get(), "abcdef", 6), 6);
    EXPECT_EQ(read_file(path, 4, FileKinds::any), "abcd");
    EXPECT_EQ(read_file("/dev/null", kMost, FileKinds::any), "");
}

/// Nothing is at the address 0 of a process.
TEST_F(ReadsFiles, NotIfTheKernelRefuses) {
    EXPECT_EQ(error("/proc/self/mem"), "Input/output error");
}

TEST_F(ReadsFiles, WithSecretsOnlyIfOthersMayNotUseThem) {
    const std::string path = folder_.write("secret", "abc");
    for (const mode_t mode : {0600U, 0640U, 0770U}) {
        ASSERT_EQ(::chmod(path.c_str(), mode), 0);
        EXPECT_EQ(read_file(path, kMost, FileKinds::secret), "abc") << mode;
    }
    for (const mode_t mode : {0601U, 0602U, 0604U}) {
        ASSERT_EQ(::chmod(path.c_str(), mode), 0);
        EXPECT_EQ(error(path, FileKinds::secret), "its mode 60" + std::to_string(mode & 7U) +
                                                      " lets others use it; run: chmod o= " + path);
        EXPECT_EQ(read_file(path, kMost), "abc") << "it is no secret";
    }
}

}  // namespace
}  // namespace tribus::test::read_file_test
