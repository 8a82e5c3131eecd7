#include "app/web/recordings/recording_tar.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace tribus::test::recording_tar_test {
namespace {

using namespace web;
namespace fs = std::filesystem;

constexpr const char* kName = "2026-11-22T12-00-05Z-failsafe";

std::string zeros(std::size_t count) {
    return std::string(count, '\0');
}

/// The fields in the order of POSIX.1-2017, pax, "ustar Header Block"; the sum was counted apart.
TEST(RecordingTar, AHeaderIsThatOfTheStandard) {
    const std::string expected = "2026-11-22T12-00-05Z-failsafe/a.txt" + zeros(65) +
                                 std::string(
                                     "0000644\0"
                                     "0000000\0"
                                     "0000000\0"
                                     "00000000005\0"
                                     "15300331445\0"
                                     "012637\0 "
                                     "0",
                                     8 + 8 + 8 + 12 + 12 + 8 + 1) +
                                 zeros(100) +
                                 std::string(
                                     "ustar\0"
                                     "00",
                                     8) +
                                 zeros(247);
    ASSERT_EQ(expected.size(), kTarBlock);
    EXPECT_EQ(
        tar_header({.name = std::string(kName) + "/a.txt", .bytes = 5, .changed = 015300331445}),
        expected);
}

TEST(RecordingTar, ALongNameStandsInAHeaderBefore) {
    const std::string name = std::string(kName) + "/" + std::string(71, 'n');
    ASSERT_EQ(name.size(), 101U);
    const std::string header = tar_header({.name = name, .bytes = 7, .changed = 1});
    ASSERT_EQ(header.size(), 3 * kTarBlock);
    EXPECT_EQ(header[156], 'x');
    EXPECT_EQ(header.substr(124, 12), std::string("00000000157\0", 12)) << "111 bytes, in octal";
    EXPECT_EQ(header.substr(kTarBlock, 111), "111 path=" + name + "\n");
    EXPECT_EQ(header[2 * kTarBlock + 156], '0');
    EXPECT_EQ(tar_header({.name = name.substr(1), .bytes = 7, .changed = 1}).size(), kTarBlock);
}

TEST(RecordingTar, ThePaddingFillsABlock) {
    EXPECT_EQ(tar_padding(0), 0U);
    EXPECT_EQ(tar_padding(1), 511U);
    EXPECT_EQ(tar_padding(511), 1U);
    EXPECT_EQ(tar_padding(512), 0U);
    EXPECT_EQ(tar_padding(513), 511U);
}

class TarOfAFolder : public testing::Test {
  protected:
    TarOfAFolder() { fs::create_directory(folder_.path() / kName); }
    void write(const std::string& name, const std::string& content) {
        folder_.write(std::string(kName) + "/" + name, content);
    }
    RecordingTar open() const { return *RecordingTar::open(folder_.path(), kName); }
    /// All pieces; nothing if it breaks off.
    static std::optional<std::string> read(RecordingTar& tar) {
        std::string all;
        for (;;) {
            const auto piece = tar.next();
            if (!piece) {
                return std::nullopt;
            }
            if (piece->empty()) {
                return all;
            }
            EXPECT_LE(piece->size(), 34'000U) << "no file is in memory as a whole";
            all += *piece;
        }
    }

    TemporaryFolder folder_;
};

TEST_F(TarOfAFolder, HasEachFileInTheOrderOfNamesAndTheLengthThatWasSaid) {
    write("b.txt", std::string(100'000, 'b'));
    write("a.txt", "");
    write("c.txt", std::string(512, 'c'));
    RecordingTar tar = open();
    const auto all = read(tar);
    ASSERT_TRUE(all);
    EXPECT_EQ(all->size(), tar.bytes());
    EXPECT_EQ(all->size(), 512U + 512 + 100'352 + 512 + 512 + 1024);
    EXPECT_EQ(all->find("a.txt"), 30U);
    EXPECT_EQ(all->find("b.txt"), 512U + 30);
    EXPECT_EQ(all->substr(1024, 100'000), std::string(100'000, 'b'));
    EXPECT_EQ(all->substr(101'376 + 512, 512), std::string(512, 'c'));
    EXPECT_EQ(all->substr(all->size() - 1024), zeros(1024));
    EXPECT_EQ(tar.next(), "") << "the end stays the end";
}

TEST_F(TarOfAFolder, LeavesOutWhatIsNoFile) {
    write("a.txt", "1");
    fs::create_symlink("/etc/passwd", folder_.path() / kName / "b.txt");
    fs::create_directory(folder_.path() / kName / "c.txt");
    RecordingTar tar = open();
    EXPECT_EQ(read(tar)->size(), 512U + 512 + 1024);
}

TEST_F(TarOfAFolder, BreaksOffIfAFileIsShorterThanItWas) {
    write("a.txt", std::string(100'000, 'a'));
    RecordingTar tar = open();
    fs::resize_file(folder_.path() / kName / "a.txt", 50'000);
    EXPECT_FALSE(read(tar));
}

TEST_F(TarOfAFolder, BreaksOffIfAFileIsGoneOrALinkTookItsPlace) {
    write("a.txt", "1");
    RecordingTar gone = open();
    RecordingTar linked = open();
    fs::remove(folder_.path() / kName / "a.txt");
    EXPECT_FALSE(read(gone));
    fs::create_symlink("/etc/passwd", folder_.path() / kName / "a.txt");
    EXPECT_FALSE(read(linked));
}

TEST_F(TarOfAFolder, HasNoMoreOfAFileThatGrowsThanItSaid) {
    write("a.txt", "1");
    RecordingTar tar = open();
    write("a.txt", std::string(10'000, '2'));
    EXPECT_EQ(read(tar)->size(), tar.bytes());
}

TEST_F(TarOfAFolder, IsNoneOfALinkToAFolder) {
    fs::create_directory_symlink(folder_.path() / kName, folder_.path() / "link");
    EXPECT_FALSE(RecordingTar::open(folder_.path(), "link"));
}

}  // namespace
}  // namespace tribus::test::recording_tar_test
