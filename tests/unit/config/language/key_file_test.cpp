#include "config/language/key_file.h"

#include <sys/stat.h>

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "config/load.h"
#include "config/show/effective.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/config/main_job.h"

namespace tribus::test::key_file_test {
namespace {

const std::string kDigits = "000102030405060708090a0b0c0d0e0f101112131415161718191A1B1C1D1E1F";
const std::string kAllowed =
    "; allowed: the path of a file with 32 bytes or 64 hexadecimal digits, which only its owner "
    "and group may read";

SecretKey counted() {
    SecretKey secret{};
    for (std::size_t i = 0; i < secret.size(); ++i) {
        secret[i] = static_cast<std::uint8_t>(i);
    }
    return secret;
}

class KeyFiles : public ::testing::Test {
  protected:
    void write(const std::string& content, mode_t mode = 0640) const {
        ::chmod(folder_.write("drone.key", content).c_str(), mode);
    }
    /// Reads `key = NAME` of a file in the folder.
    std::optional<KeyFile> read(const std::string& name = "drone.key") {
        mistakes_ = Mistakes(folder_ / "t.toml");
        return read_key_file("key", {.where = {3, 7}, .content = name}, mistakes_);
    }
    /// The only mistake, without its place and without what is allowed.
    std::string mistake() const {
        const auto all = mistakes_.sorted();
        EXPECT_EQ(all.size(), 1U);
        const std::string text = all.empty() ? "" : all[0].text;
        EXPECT_TRUE(text.ends_with(kAllowed)) << text;
        return text.substr(0, text.size() - std::min(text.size(), kAllowed.size()));
    }
    bool may_be_temporary() const { return tribus::may_be_temporary(mistakes_.sorted()); }

    const TemporaryFolder folder_;
    Mistakes mistakes_{""};
};

/// Such as the page, which judges configurations.
TEST_F(KeyFiles, AreNotOpenedByAProgramThatMustNotHaveThem) {
    write(kDigits);
    forbid_secrets();
    const auto one = read();
    const auto other = read("absent.key");
    forbid_secrets(false);
    ASSERT_TRUE(one && other);
    EXPECT_TRUE(mistakes_.empty());
    EXPECT_NE(one->secret, counted());
    EXPECT_NE(one->secret, SecretKey{});
    EXPECT_NE(one->secret, other->secret) << "different files have different keys";
    EXPECT_EQ(read()->secret, counted());
}

TEST_F(KeyFiles, HoldBytesOrDigits) {
    const SecretKey secret = counted();
    for (const std::string& content :
         {std::string(secret.begin(), secret.end()), kDigits, kDigits + "\n", kDigits + "\r\n"}) {
        for (const mode_t mode : {0400U, 0600U, 0640U}) {
            write(content, mode);
            EXPECT_EQ(read(), (KeyFile{"drone.key", secret})) << content;
        }
    }
    EXPECT_EQ(read(folder_ / "drone.key")->secret, secret);
}

TEST_F(KeyFiles, ThatOthersMayUseAreRefused) {
    for (const auto& [mode, word] : std::vector<std::pair<mode_t, std::string>>{
             {0644, "644"}, {0604, "604"}, {0602, "602"}, {0666, "666"}}) {
        write(kDigits, mode);
        EXPECT_EQ(read(), std::nullopt);
        EXPECT_EQ(mistake(), "\"key\" is \"drone.key\": its mode " + word +
                                 " lets others use it; run: chmod o= " + (folder_ / "drone.key"));
        EXPECT_TRUE(may_be_temporary());
    }
}

TEST_F(KeyFiles, ThatAreNotThereAreRefused) {
    EXPECT_EQ(read(), std::nullopt);
    EXPECT_EQ(mistake(), "\"key\" is \"drone.key\": No such file or directory");
    EXPECT_TRUE(may_be_temporary());
    EXPECT_EQ(read("/dev/zero"), std::nullopt);
    EXPECT_EQ(mistake(), "\"key\" is \"/dev/zero\": it is a device or a pipe, not a file");
    EXPECT_EQ(read(""), std::nullopt);
    EXPECT_EQ(mistake(), "\"key\" is \"\": not the path of a file");
    EXPECT_FALSE(may_be_temporary());
}

TEST_F(KeyFiles, AreRefusedWithAnotherLength) {
    for (const std::size_t length : {0U, 1U, 31U, 33U, 63U, 65U, 66U}) {
        write(std::string(length, 'a'));
        EXPECT_EQ(read(), std::nullopt);
        EXPECT_EQ(mistake(), "\"key\" is \"drone.key\": it has " + std::to_string(length) +
                                 " bytes that are no key");
        EXPECT_FALSE(may_be_temporary());
    }
    write(std::string(5000, 'a'));
    EXPECT_EQ(read(), std::nullopt);
    EXPECT_EQ(mistake(), "\"key\" is \"drone.key\": it has more than 66 bytes that are no key");
}

TEST_F(KeyFiles, WithOtherThanHexadecimalDigitsAreRefused) {
    for (const std::string_view pair : {"g0", "0g", " 1", "1 ", "-1", "+1", "0x"}) {
        for (const std::size_t at : {0U, 30U, 62U}) {
            std::string digits = kDigits;
            write(digits.replace(at, 2, pair));
            EXPECT_EQ(read(), std::nullopt) << pair;
        }
    }
}

TEST_F(KeyFiles, AreRefusedIfTheyHoldZeros) {
    for (const std::string& content : {std::string(32, '\0'), std::string(64, '0')}) {
        write(content);
        EXPECT_EQ(read(), std::nullopt);
        EXPECT_EQ(mistake(),
                  "\"key\" is \"drone.key\": a key of zeros switches signing off at other "
                  "programs");
    }
}

/// Nothing that is shown has a part of the secret, in bytes, digits or numbers.
TEST_F(KeyFiles, ShowTheirPathOnly) {
    write("5ec7e75ec7e75ec7e75ec7e75ec7e75ec7e75ec7e75ec7e75ec7e75ec7e75ec7");
    const std::string text =
        "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n"
        "[output.drone]\nprotocol = \"mavlink\"\ndevice = \"/dev/ttyB\"\nkey = \"drone.key\"\n"
        "[pipeline.main]\nfrom = \"receiver\"\nto = \"drone\"\n"
        "[values.drone]\nprotocol = \"mavlink-telemetry\"\ndevice = \"/dev/ttyB\"\n"
        "key = \"drone.key\"\n";
    const auto configuration = load_configuration(text, folder_ / "t.toml");
    ASSERT_TRUE(configuration) << configuration.error().front().text;
    for (const std::string& shown :
         {effective_toml(*configuration), effective_json(*configuration)}) {
        EXPECT_NE(shown.find("drone.key"), std::string::npos) << shown;
        for (const std::string_view part : {"5ec7", "5EC7", "\x5e\xc7", "94", "^"}) {
            EXPECT_EQ(shown.find(part), std::string::npos) << shown;
        }
    }
}

TEST_F(KeyFiles, WithAnotherSecretMakeAnotherConfiguration) {
    const std::string text =
        "[input.drone]\nprotocol = \"mavlink\"\ndevice = \"/dev/ttyA\"\nkey = \"drone.key\"\n"
        "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
        "[pipeline.main]\nfrom = \"drone\"\nto = \"servos\"\n";
    write(kDigits);
    const auto before = load_configuration(text, folder_ / "t.toml");
    write(std::string(64, 'a'));
    const auto after = load_configuration(text, folder_ / "t.toml");
    ASSERT_TRUE(before && after);
    EXPECT_FALSE(before->inputs[0].settings == after->inputs[0].settings);
}

TEST_F(KeyFiles, AreOnlyForProtocolsWithSignatures) {
    write(kDigits);
    const std::string text =
        main_job_with(10,
                      "[values.drone]\nprotocol = \"crsf-telemetry\"\ndevice = \"/dev/ttyC\"\n"
                      "key = \"drone.key\"");
    EXPECT_EQ(mistakes_in(text, folder_ / "t.toml"),
              std::vector<std::string>{(folder_ / "t.toml") +
                                       ":13:1: \"key\" has no effect with protocol "
                                       "\"crsf-telemetry\", which has no signatures; leave it "
                                       "out"});
}

/// What stands for the secret of a file that must not be read.
SecretKey stand_in(const std::string& name) {
    Mistakes mistakes("t.toml");
    forbid_secrets();
    const auto file = read_key_file("key", {.where = {3, 7}, .content = name}, mistakes);
    forbid_secrets(false);
    EXPECT_TRUE(file) << name;
    return file ? file->secret : SecretKey{};
}

TEST(StandInForAKey, IsMadeFromThePath) {
    EXPECT_EQ(stand_in("a.key"), (SecretKey{1, 'a', '.', 'k', 'e', 'y'}));
    EXPECT_EQ(stand_in("x/../a.key"), stand_in("a.key")) << "the same file";
    SecretKey of_a_long_path{};
    of_a_long_path.fill('b');
    of_a_long_path[0] = 1;
    of_a_long_path[1] = 64;  // 98 * 31 + 98
    EXPECT_EQ(stand_in(std::string(32, 'b')), of_a_long_path);
}

TEST(StandInForAKey, DiffersWithEveryLetterOfThePath) {
    const std::string path(70, 'b');
    std::set<SecretKey> all{stand_in(path)};
    for (std::size_t at = 0; at < path.size(); ++at) {
        std::string other = path;
        other[at] = 'c';
        EXPECT_TRUE(all.insert(stand_in(other)).second) << at;
    }
}

TEST(ForbiddenSecrets, AreAllowedAgainWhereThatIsSaid) {
    EXPECT_FALSE(are_secrets_forbidden());
    forbid_secrets();
    EXPECT_TRUE(are_secrets_forbidden());
    forbid_secrets(false);
    EXPECT_FALSE(are_secrets_forbidden());
}

TEST_F(KeyFiles, AreReadByTheirPathAlone) {
    write(kDigits);
    EXPECT_EQ(read_secret(folder_ / "drone.key"), counted());
    write("abc");
    ASSERT_FALSE(read_secret(folder_ / "drone.key"));
    EXPECT_EQ(read_secret(folder_ / "drone.key").error(), "it has 3 bytes that are no key");
    EXPECT_EQ(read_secret(folder_ / "none.key").error(), "No such file or directory");
}

TEST_F(KeyFiles, EndWithOneEndOfLineAtMost) {
    for (const std::string end : {"\n\n", "\r\r", "\n\r", " \n"}) {
        write(kDigits + end);
        EXPECT_EQ(read(), std::nullopt) << end;
    }
    write(kDigits + "\r");
    EXPECT_EQ(read()->secret, counted());
}

TEST_F(KeyFiles, AreNotNamedByOtherValues) {
    Mistakes mistakes("t.toml");
    EXPECT_EQ(read_key_file("key", {.where = {3, 7}, .content = std::int64_t{5}}, mistakes),
              std::nullopt);
    EXPECT_EQ(mistakes.sorted().at(0).text, "\"key\" is 5: not the path of a file" + kAllowed);
}

}  // namespace
}  // namespace tribus::test::key_file_test
