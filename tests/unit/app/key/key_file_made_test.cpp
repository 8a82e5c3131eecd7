#include "app/key/key_file_made.h"

#include <sys/stat.h>

#include <set>
#include <string>

#include <gtest/gtest.h>

#include "config/language/key_file.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

namespace tribus::test::key_file_made_test {
namespace {

mode_t mode_of(const std::string& path) {
    struct stat told {};
    EXPECT_EQ(::stat(path.c_str(), &told), 0) << path;
    return told.st_mode & 07777U;
}

/// Computed with Python: sha256(b"tribus key fingerprint" + bytes(range(32))).hexdigest()[:16].
TEST(Fingerprint, IsThatOfTheKeyAndItsPurpose) {
    SecretKey secret{};
    for (std::size_t i = 0; i < secret.size(); ++i) {
        secret[i] = static_cast<std::uint8_t>(i);
    }
    EXPECT_EQ(fingerprint(secret), "f9f0-c439-1310-5eba");
}

TEST(MadeKeyFile, HasTheKeyThatAConfigurationReads) {
    const TemporaryFolder folder;
    const auto made = make_key_file(folder / "boat.key");
    ASSERT_TRUE(made) << made.error();
    const auto read = read_secret(folder / "boat.key");
    ASSERT_TRUE(read) << read.error();
    EXPECT_EQ(*read, made->secret);
    EXPECT_EQ(folder.read("boat.key").size(), 65U) << "64 digits and the end of the line";
}

TEST(MadeKeyFile, IsForItsOwnerWhateverTheUmaskAllows) {
    const TemporaryFolder folder;
    const mode_t before = ::umask(0);
    const auto made = make_key_file(folder / "boat.key");
    ::umask(before);
    ASSERT_TRUE(made) << made.error();
    EXPECT_EQ(mode_of(folder / "boat.key"), made->service_reads ? 0640U : 0600U);
}

TEST(MadeKeyFile, HasAnotherKeyEachTime) {
    const TemporaryFolder folder;
    std::set<std::string> fingerprints;
    for (int i = 0; i < 16; ++i) {
        const auto made = make_key_file(folder / std::to_string(i));
        ASSERT_TRUE(made) << made.error();
        fingerprints.insert(fingerprint(made->secret));
    }
    EXPECT_EQ(fingerprints.size(), 16U);
}

TEST(MadeKeyFile, NeverReplacesAFile) {
    const TemporaryFolder folder;
    const std::string file = folder.write("boat.key", "what links use today");
    const auto made = make_key_file(file);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error(), file + ": is there already, and stays as it is; name another file");
    EXPECT_EQ(folder.read("boat.key"), "what links use today");
}

TEST(MadeKeyFile, IsNotWrittenWhereALinkLeads) {
    const TemporaryFolder folder;
    std::filesystem::create_symlink(folder / "elsewhere", folder / "boat.key");
    EXPECT_FALSE(make_key_file(folder / "boat.key"));
    EXPECT_FALSE(std::filesystem::exists(folder / "elsewhere"));
}

TEST(MadeKeyFile, SaysWhichFolderIsMissing) {
    const TemporaryFolder folder;
    const auto made = make_key_file(folder / "keys/boat.key");
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error(), folder / "keys/boat.key" + ": no folder is called " +
                                (folder / "keys") + "; run: sudo install -d " + (folder / "keys"));
}

TEST(KeyCommand, ShowsTheFingerprintThatItMadeAndNeverTheKey) {
    const TemporaryFolder folder;
    const std::string file = folder / "boat.key";
    const Ended made = run_in_shell("\"$TRIBUS\" key new " + file);
    ASSERT_EQ(made.status, 0) << made.output;
    const Ended shown = run_in_shell("\"$TRIBUS\" key show --fingerprint " + file);
    ASSERT_EQ(shown.status, 0) << shown.output;
    ASSERT_EQ(shown.output.size(), 20U) << shown.output;
    EXPECT_NE(made.output.find("a new key, fingerprint " + shown.output), std::string::npos)
        << made.output;
    const std::string digits = folder.read("boat.key").substr(0, 64);
    for (std::size_t at = 0; at + 8 <= digits.size(); ++at) {
        EXPECT_EQ(made.output.find(digits.substr(at, 8)), std::string::npos) << made.output;
    }
}

TEST(KeyCommand, RefusesAFileThatOthersMayRead) {
    const TemporaryFolder folder;
    const std::string file = folder.write("boat.key", std::string(64, 'a'));
    ::chmod(file.c_str(), 0644);
    const Ended shown = run_in_shell("\"$TRIBUS\" key show " + file + " 2>&1");
    EXPECT_EQ(shown.status, 1);
    EXPECT_EQ(shown.output, "tribus: " + file +
                                ": its mode 644 lets others use it; run: chmod o= " + file +
                                "; allowed: " + std::string(kAllowedKeyFile) + "\n");
}

TEST(KeyCommand, NeedsAnActionThatItKnows) {
    EXPECT_EQ(run_in_shell("\"$TRIBUS\" key burn boat.key 2>&1").status, 2);
}

}  // namespace
}  // namespace tribus::test::key_file_made_test
