#include "app/web/pairing/pairing.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "app/web/http/cookie.h"
#include "tests/support/temporary_folder.h"
#include "transports/links/unique_fd.h"

namespace tribus::test::pairing_test {
namespace {

using namespace web;
using namespace std::chrono_literals;

constexpr WallTime kNow = 1'795'348'805s;

class Pairing : public testing::Test {
  protected:
    std::string code(Role role = Role::change) { return folder_.make_code(role, kNow).value(); }
    CodeTried tried(const std::string& typed, WallTime at = kNow) {
        return folder_.try_code(typed, at).value();
    }

    TemporaryFolder place_;
    PairingFolder folder_{place_.path()};
};

TEST_F(Pairing, ACodeIsGoodOnce) {
    const std::string given = code(Role::look);
    EXPECT_EQ(given.size(), 8U);
    EXPECT_EQ(tried(given).role, Role::look);
    EXPECT_FALSE(tried(given).role);
    EXPECT_FALSE(tried(given).any_valid);
}

TEST_F(Pairing, ACodeMayBeTypedInSmallLettersWithBlanksAndDashes) {
    std::string typed = code();
    std::ranges::transform(typed, typed.begin(), [](unsigned char c) { return std::tolower(c); });
    EXPECT_TRUE(tried(" " + typed.substr(0, 4) + "-" + typed.substr(4) + " ").role);
}

TEST_F(Pairing, LetsChangeWhileABrowserOrACodeMay) {
    EXPECT_FALSE(folder_.lets_change(kNow));
    code(Role::look);
    EXPECT_FALSE(folder_.lets_change(kNow));
    tried(code());
    EXPECT_FALSE(folder_.lets_change(kNow)) << "the code is used up";
    code();
    EXPECT_TRUE(folder_.lets_change(kNow));
    const WallTime later = kNow + PairingFolder::kCodeLasts;
    EXPECT_FALSE(folder_.lets_change(later));
    ASSERT_TRUE(folder_.add_session("phone", Role::look, "1", later));
    EXPECT_FALSE(folder_.lets_change(later));
    ASSERT_TRUE(folder_.add_session("laptop", Role::change, "2", later));
    EXPECT_TRUE(folder_.lets_change(later));
    EXPECT_FALSE(folder_.lets_change(later + PairingFolder::kSessionLasts));
    ASSERT_EQ(folder_.revoke("laptop").value(), 1U);
    EXPECT_FALSE(folder_.lets_change(later));
}

/// The folder is the page's, and root writes there.
TEST_F(Pairing, WritesNoFileOfAnotherAndWaitsForNoPipe) {
    place_.write("other", "of somebody else");
    std::filesystem::create_hard_link(place_ / "other", place_ / "code.json.new");
    EXPECT_TRUE(tried(code()).role);
    ASSERT_EQ(::mkfifo((place_ / "code.json.new").c_str(), 0666), 0);
    EXPECT_TRUE(tried(code()).role);
    EXPECT_EQ(place_.read("other"), "of somebody else");
}

TEST_F(Pairing, DoesNotWaitForOneWhoHoldsTheFolder) {
    const UniqueFd held(::open(place_.path().c_str(), O_RDONLY | O_DIRECTORY));
    ASSERT_EQ(::flock(held.get(), LOCK_EX), 0);
    const auto refused = folder_.make_code(Role::change, kNow);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().find("another program holds it"), std::string::npos)
        << refused.error();
}

TEST_F(Pairing, LetsNobodyChangeWhoseFileIsGoneOrCannotBeRead) {
    ASSERT_TRUE(folder_.add_session("laptop", Role::change, "2", kNow));
    EXPECT_TRUE(folder_.lets_change(kNow));
    std::filesystem::remove(folder_.sessions_file());
    EXPECT_FALSE(folder_.lets_change(kNow));
    std::filesystem::create_directory(folder_.sessions_file());
    EXPECT_FALSE(folder_.lets_change(kNow));
}

TEST_F(Pairing, WrongTriesDoNotEndACode) {
    const std::string given = code();
    for (int i = 0; i < 1000; ++i) {
        const CodeTried wrong = tried("AAAAAAAA");
        ASSERT_FALSE(wrong.role);
        ASSERT_TRUE(wrong.any_valid);
    }
    EXPECT_EQ(tried(given).role, Role::change);
    EXPECT_FALSE(tried(given).any_valid);
}

TEST_F(Pairing, ACodeLastsFiveMinutesAlsoIfTheClockIsSetBack) {
    EXPECT_TRUE(tried(code(), kNow + PairingFolder::kCodeLasts - 1s).role);
    EXPECT_FALSE(tried(code(), kNow + PairingFolder::kCodeLasts).role);
    EXPECT_FALSE(tried(code(), kNow - 1s).role) << "set back, it would last longer";
}

TEST_F(Pairing, ANewCodeTakesThePlaceOfTheOneBefore) {
    const std::string first = code();
    const std::string second = code();
    EXPECT_FALSE(tried(first).role);
    EXPECT_TRUE(tried(second).role);
}

TEST_F(Pairing, CodesAndCookiesAreAllDifferent) {
    std::set<std::string> codes;
    std::set<std::string> cookies;
    for (int i = 0; i < 100; ++i) {
        codes.insert(code());
        cookies.insert(new_cookie().value());
    }
    EXPECT_EQ(codes.size(), 100U);
    EXPECT_EQ(cookies.size(), 100U);
    EXPECT_EQ(cookies.begin()->size(), 64U);
}

TEST_F(Pairing, KeepsTheHashOfACookieAndNotTheCookie) {
    const std::string cookie = new_cookie().value();
    ASSERT_TRUE(folder_.add_session("phone", Role::look, hash_of_cookie(cookie), kNow));
    std::ifstream file(folder_.sessions_file());
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(text.find(cookie), std::string::npos);
    const auto sessions = folder_.sessions().value();
    EXPECT_NE(find_session(sessions, hash_of_cookie(cookie), kNow), nullptr);
    EXPECT_EQ(find_session(sessions, hash_of_cookie(new_cookie().value()), kNow), nullptr);
    EXPECT_EQ(find_session(sessions, "", kNow), nullptr);
    // SHA-256 of 64 zeros, by sha256sum.
    EXPECT_EQ(hash_of_cookie(std::string(64, '0')),
              "60e05bd1b195af2f94112fa7197a5c88289058840ce7c6df9693756bc6250f55");
}

TEST_F(Pairing, ABrowserIsForgottenAfterNinetyDays) {
    ASSERT_TRUE(folder_.add_session("phone", Role::look, "h", kNow));
    const auto sessions = folder_.sessions().value();
    EXPECT_NE(find_session(sessions, "h", kNow + PairingFolder::kSessionLasts - 1s), nullptr);
    EXPECT_EQ(find_session(sessions, "h", kNow + PairingFolder::kSessionLasts), nullptr);
}

TEST_F(Pairing, RevokesByNameAndLeavesByCookie) {
    ASSERT_TRUE(folder_.add_session("phone", Role::look, "1", kNow));
    ASSERT_TRUE(folder_.add_session("phone", Role::change, "2", kNow));
    ASSERT_TRUE(folder_.add_session("desk", Role::change, "3", kNow));
    ASSERT_TRUE(folder_.add_session("tablet\n\"x", Role::change, "4", kNow));
    EXPECT_EQ(folder_.sessions()->back().name, "tablet?\"x");
    EXPECT_EQ(folder_.revoke("phone"), 2U);
    EXPECT_EQ(folder_.revoke("phone"), 0U);
    ASSERT_TRUE(folder_.leave("4"));
    const auto left = folder_.sessions().value();
    ASSERT_EQ(left.size(), 1U);
    EXPECT_EQ(left[0].name, "desk");
}

TEST_F(Pairing, SessionsInMemoryAreThoseOfTheFile) {
    SessionsInMemory memory;
    EXPECT_TRUE(memory.of(folder_).empty());
    ASSERT_TRUE(folder_.add_session("phone", Role::look, "1", kNow));
    ASSERT_TRUE(folder_.add_session("desk", Role::change, "2", kNow));
    EXPECT_EQ(memory.of(folder_).size(), 2U);
    EXPECT_EQ(folder_.revoke("phone"), 1U);
    ASSERT_EQ(memory.of(folder_).size(), 1U);
    EXPECT_EQ(memory.of(folder_)[0].name, "desk");
    std::filesystem::remove(folder_.sessions_file());
    EXPECT_TRUE(memory.of(folder_).empty());
}

TEST_F(Pairing, FilesThatSomebodySpoiledLetNobodyIn) {
    for (const auto* text : {"", "{", "[]", "[1,null,{}]", "{\"role\":\"change\"}",
                             "[{\"role\":\"change\",\"hash\":7,\"made\":\"x\"}]",
                             "[{\"role\":\"root\",\"hash\":\"h\",\"made\":0}]"}) {
        std::ofstream(folder_.sessions_file()) << text;
        std::ofstream(place_.path() / "code.json") << text;
        const auto sessions = folder_.sessions();
        EXPECT_TRUE(!sessions || find_session(*sessions, "h", kNow) == nullptr) << text;
        const auto tried = folder_.try_code("", kNow);
        EXPECT_TRUE(!tried || !tried->role) << text;
    }
}

TEST_F(Pairing, AFolderThatIsNotThereIsAnErrorThatNamesIt) {
    PairingFolder none(place_.path() / "none");
    const auto code = none.make_code(Role::look, kNow);
    ASSERT_FALSE(code);
    EXPECT_NE(code.error().find((place_.path() / "none").string()), std::string::npos);
}

}  // namespace
}  // namespace tribus::test::pairing_test
