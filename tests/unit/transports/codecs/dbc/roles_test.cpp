#include "transports/codecs/dbc/roles.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tests/support/dbc_maps.h"
#include "transports/codecs/dbc/signal_keys.h"

namespace tribus::roles_test {
namespace {

using Lines = std::vector<std::string>;

template <class Role>
Role role(std::string_view json) {
    std::vector<SettingMistake> mistakes;
    const auto read = read_dbc_role(test::setting_tree(json), {"signals", "M", "S"}, mistakes);
    EXPECT_EQ(test::told(mistakes), Lines{});
    const Role* found = read ? std::get_if<Role>(&*read) : nullptr;
    EXPECT_NE(found, nullptr) << json;
    return found == nullptr ? Role{} : *found;
}

Lines mistakes_of_signals(std::string_view json) {
    std::vector<SettingMistake> mistakes;
    read_dbc_role(test::setting_tree(json), {"signals", "M", "S"}, mistakes);
    return test::told(mistakes);
}

TEST(DbcRole, ANumberIsAChannel) {
    EXPECT_EQ(role<DbcChannelRole>("18").channel, 17U);
    EXPECT_FALSE(role<DbcChannelRole>("18").value);
    EXPECT_EQ(role<DbcChannelRole>("18").microseconds, (std::array{1000.0, 2000.0}));
}

TEST(DbcRole, AChannelMayTellAllOfItself) {
    const auto channel = role<DbcChannelRole>(
        R"({"channel": 2, "value": [-1.5, 2], "us": [2000, 1000.5], "not_available": -1,
            "error": 254, "optional": true, "negative": "N", "positive": "P", "neutral": "Z"})");
    EXPECT_EQ(channel.channel, 1U);
    EXPECT_EQ(channel.value, (std::array{-1.5, 2.0}));
    EXPECT_EQ(channel.microseconds, (std::array{2000.0, 1000.5}));
    EXPECT_EQ(channel.not_available, -1);
    EXPECT_EQ(channel.error, 254);
    EXPECT_TRUE(channel.optional);
    EXPECT_EQ(channel.negative, "N");
    EXPECT_EQ(channel.positive, "P");
    EXPECT_EQ(channel.neutral, "Z");
}

TEST(DbcRole, FlagsHaveFourMeanings) {
    EXPECT_EQ(role<DbcFlagRole>(R"({"flag": "failsafe"})").meaning, DbcFlagMeaning::failsafe);
    EXPECT_EQ(role<DbcFlagRole>(R"({"flag": "frame_lost"})").meaning, DbcFlagMeaning::frame_lost);
    EXPECT_EQ(role<DbcFlagRole>(R"({"flag": "good"})").meaning, DbcFlagMeaning::good);
    EXPECT_EQ(role<DbcFlagRole>(R"({"flag": "cause"})").meaning, DbcFlagMeaning::cause);
}

TEST(DbcRole, FixedCounterAndChecksum) {
    EXPECT_EQ(role<DbcFixedRole>(R"({"fixed": -2.5})").value, -2.5);
    EXPECT_EQ(role<DbcCounterRole>(R"({"counter": true})").most, std::nullopt);
    EXPECT_EQ(role<DbcCounterRole>(R"({"counter": true, "most": 14})").most, 14);
    const auto checksum = role<DbcChecksumRole>(R"({"checksum": "p05", "data_id": 65535})");
    EXPECT_EQ(checksum.kind, DbcChecksumKind::p05);
    EXPECT_EQ(checksum.data_id, 65535);
}

struct Wrong {
    std::string_view json;
    std::string_view expected;
};

class WrongDbcRole : public testing::TestWithParam<Wrong> {};

TEST_P(WrongDbcRole, IsToldWithWhatIsAllowed) {
    EXPECT_EQ(mistakes_of_signals(GetParam().json), Lines{std::string(GetParam().expected)});
}

constexpr std::string_view kUnclear =
    "signals.M.S: this gives the signal no role; allowed: a channel number, or one of "
    "{ channel = 1 }, { flag = \"failsafe\" }, { fixed = 0 }, { counter = true }, "
    "{ checksum = \"xor\" }, { from = \"battery.voltage\" }";

INSTANTIATE_TEST_SUITE_P(
    All, WrongDbcRole,
    testing::Values(
        Wrong{"0", "signals.M.S: there is no channel 0; allowed: 1 to 18"},
        Wrong{"19", "signals.M.S: there is no channel 19; allowed: 1 to 18"},
        Wrong{"1.5", kUnclear}, Wrong{"\"Speed\"", kUnclear}, Wrong{"[1]", kUnclear},
        Wrong{"{}", kUnclear}, Wrong{R"({"value": [0, 1]})", kUnclear},
        Wrong{R"({"channel": 19})",
              "signals.M.S.channel: there is no channel 19; allowed: 1 to 18"},
        Wrong{R"({"channel": "1"})",
              "signals.M.S.channel: \"channel\" has a wrong value; allowed: a channel number "
              "from 1 to 18"},
        Wrong{R"({"channel": 1, "value": [1, 1]})",
              "signals.M.S.value: \"value\" has a wrong value; allowed: two different numbers, "
              "such as [-100, 100]"},
        Wrong{R"({"channel": 1, "us": [1000]})",
              "signals.M.S.us: \"us\" has a wrong value; allowed: two different numbers, such "
              "as [-100, 100]"},
        Wrong{R"({"channel": 1, "us": [-1, 2000]})",
              "signals.M.S.us: this is not a servo pulse; allowed: 0 to 4000 microseconds"},
        Wrong{R"({"channel": 1, "error": 1.5})",
              "signals.M.S.error: \"error\" has a wrong value; allowed: a raw value, a whole "
              "number"},
        Wrong{R"({"channel": 1, "error": 3, "not_available": 3})",
              "signals.M.S.error: \"not_available\" already has this code; allowed: another "
              "raw value, or one of the two keys"},
        Wrong{R"({"channel": 1, "optional": 1})",
              "signals.M.S.optional: \"optional\" has a wrong value; allowed: true or false"},
        Wrong{R"({"channel": 1, "negative": ""})",
              "signals.M.S.negative: \"negative\" has a wrong value; allowed: the name of a "
              "signal of the same message"},
        Wrong{R"({"channel": 1, "neutral": "Z"})",
              "signals.M.S.channel: \"positive\" and \"neutral\" give the direction of a magnitude "
              "together with \"negative\"; allowed: all of them, or \"negative\" alone"},
        Wrong{R"({"channel": 1, "flag": "good"})",
              "signals.M.S.flag: unknown key \"flag\"; allowed here: \"channel\", \"value\", "
              "\"us\", \"not_available\", \"error\", \"optional\", \"negative\", \"positive\", "
              "\"neutral\""},
        Wrong{R"({"flag": "godo"})",
              "signals.M.S.flag: there is no flag \"godo\"; allowed: \"failsafe\", "
              "\"frame_lost\", \"good\", \"cause\""},
        Wrong{R"({"fixed": true})",
              "signals.M.S.fixed: \"fixed\" has a wrong value; allowed: a number"},
        Wrong{R"({"counter": false})",
              "signals.M.S.counter: this gives the signal no role; allowed: true, or no entry for "
              "the signal"},
        Wrong{R"({"counter": true, "most": 0})",
              "signals.M.S.most: a counter that never changes is useless; allowed: 1 or more"},
        Wrong{R"({"checksum": "crc"})",
              "signals.M.S.checksum: there is no checksum \"crc\"; allowed: \"xor\", \"sum\", "
              "\"agilex\", \"crc8_j1850\", \"crc8_2f\", \"p01\", \"p05\""},
        Wrong{R"({"checksum": "p01", "data_id": 65536})",
              "signals.M.S.data_id: a data id has 16 bits; allowed: 0 to 65535"},
        Wrong{R"({"checksum": "xor", "data_id": 1})",
              "signals.M.S.data_id: \"xor\" has no data id; allowed: with \"p01\" and \"p05\" "
              "only"}));

/// The keys that the reader knows beside `json`, as its message about an unknown one lists them.
std::set<std::string> known_keys(std::string_view json) {
    const Lines told = mistakes_of_signals(json);
    const std::string text = told.empty() ? "" : told.back();
    std::set<std::string> keys;
    std::size_t at = text.find("allowed here: ");
    while ((at = text.find('"', at)) != std::string::npos) {
        const std::size_t end = text.find('"', at + 1);
        keys.insert(text.substr(at + 1, end - at - 1));
        at = end + 1;
    }
    return keys;
}

TEST(DbcRole, TheManualListsTheKeysThatAreRead) {
    std::set<std::string> read;
    for (const std::string_view json :
         {R"({"channel": 1, "?": 0})", R"({"flag": "good", "?": 0})", R"({"fixed": 5, "?": 0})",
          R"({"counter": true, "?": 0})", R"({"checksum": "p01", "?": 0})",
          R"({"from": "a", "?": 0})"}) {
        read.merge(known_keys(json));
    }
    std::set<std::string> listed;
    for (const Setting& setting : kDbcSignalKeys) {
        listed.emplace(setting.key);
    }
    EXPECT_EQ(listed, read);
}

TEST(DbcRole, TheManualListsTheWordsThatAreRead) {
    for (const std::string_view flag : kDbcFlagChoices) {
        EXPECT_EQ(mistakes_of_signals(R"({"flag": ")" + std::string(flag) + R"("})"), Lines{})
            << flag;
    }
    for (const std::string_view checksum : kDbcChecksumChoices) {
        EXPECT_EQ(mistakes_of_signals(R"({"checksum": ")" + std::string(checksum) + R"("})"),
                  Lines{})
            << checksum;
    }
}

}  // namespace
}  // namespace tribus::roles_test
