#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/dbc_maps.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/map.h"
#include "transports/codecs/dbc/signal.h"

/// DBC files of which one part is broken. What is used decides whether that matters.
namespace tribus::broken_parts_test {
namespace {

using namespace test;

/// The message that is used. The broken part stands behind it, from line 4.
constexpr std::string_view kUsed = R"(BO_ 256 Used: 8 A
 SG_ Steer : 0|16@1- (0.5,0) [-100|100] "" B
 SG_ Speed : 16|16@1+ (1,0) [0|1000] "" B
)";
constexpr std::string_view kUse = R"({"Used": {"Steer": 1, "Speed": 2}})";
/// The message that has the broken part in most rows.
const std::string kMessage = "BO_ 257 M: 8 A\n SG_ X : 0|8@1+ (1,0) [0|100] \"\" B\n";
constexpr std::string_view kUseOfM = R"({"M": {"X": 1}})";

struct Broken {
    std::string_view name;
    std::string lines;
    std::string_view use;      ///< of the broken part, as signals of an input
    std::string_view warning;  ///< begins so
};

void PrintTo(const Broken& broken, std::ostream* out) {
    *out << broken.name;
}

const std::vector<Broken> kBroken{
    // canmatrix' j1939.dbc has one such text among 357 messages.
    {"text_of_1600_bits",
     "BO_ 2566843134 DD: 200 A\n SG_ Text : 0|1600@1+ (1,0) [0|0] \"\" B\n" +
         j1939_frames({2566843134}),
     "", "5:15: signal Text is 1600 bits long"},
    {"signal_of_1600_bits_beside_others",
     "BO_ 257 M: 8 A\n SG_ Fine : 0|8@1+ (1,0) [0|100] \"\" B\n"
     " SG_ Text : 8|1600@1+ (1,0) [0|0] \"\" B\n",
     R"({"M": {"Text": 1}})", "6:15: signal Text is 1600 bits long"},
    // One gnss.dbc has a name under two ids.
    {"name_under_two_ids", kMessage + "BO_ 258 M: 8 A\n SG_ X : 0|8@1+ (1,0) [0|100] \"\" B\n",
     kUseOfM, "6:9: there is another message M in line 4"},
    {"id_of_two_messages", kMessage + "BO_ 257 N: 8 A\n SG_ X : 0|8@1+ (1,0) [0|100] \"\" B\n",
     kUseOfM, "6:9: message N has the id of message M in line 4"},
    {"signal_twice", kMessage + " SG_ X : 8|8@1+ (1,0) [0|100] \"\" B\n", kUseOfM,
     "6:6: message M has another signal X in line 5"},
    {"signal_beyond_the_message", "BO_ 257 M: 2 A\n SG_ X : 9|8@1+ (1,0) [0|100] \"\" B\n", kUseOfM,
     "5:6: signal X needs 3 bytes, but message M has 2"},
    {"factor_of_0", "BO_ 257 M: 2 A\n SG_ X : 0|8@1+ (0,0) [0|100] \"\" B\n", kUseOfM,
     "5:18: the factor of signal X is 0"},
    {"length_that_no_frame_has", "BO_ 257 M: 9 A\n SG_ X : 0|8@1+ (1,0) [0|100] \"\" B\n", kUseOfM,
     "4:12: message M has 9 bytes"},
    {"id_beyond_11_bits", "BO_ 201326846 M: 8 A\n SG_ X : 0|8@1+ (1,0) [0|100] \"\" B\n", kUseOfM,
     "4:5: the id of message M, 201326846, has more than 11 bits"},
    {"id_in_hex", "BO_ 0x101 M: 8 A\n SG_ X : 0|8@1+ (1,0) [0|100] \"\" B\n", kUseOfM,
     "4:5: expected the id of the message"},
    {"heading_without_a_colon", "BO_ 257 M 8 A\n SG_ X : 0|8@1+ (1,0) [0|100] \"\" B\n", "",
     "4:11: expected ':' after the name of the message"},
    {"signal_without_a_unit", "BO_ 257 M: 8 A\n SG_ X : 0|8@1+ (1,0) [0|100] B\n", kUseOfM,
     "5:31: expected the unit in quotes"},
    {"float_of_8_bits", kMessage + "SIG_VALTYPE_ 257 X : 1;\n", kUseOfM,
     "6:14: signal X is declared as a floating-point number of 32 bits"},
    {"kind_that_there_is_not", kMessage + "SIG_VALTYPE_ 257 X : 7;\n", kUseOfM,
     "6:22: expected the kind of value"},
    {"selector_that_there_is_not", kMessage + "SG_MUL_VAL_ 257 X Page 1-1;\n", kUseOfM,
     "6:19: signal X depends on Page"},
    {"selector_that_is_broken",
     "BO_ 257 M: 8 A\n SG_ Page M : 60|8@1+ (1,0) [0|100] \"\" B\n"
     " SG_ X m1 : 0|8@1+ (1,0) [0|100] \"\" B\n",
     kUseOfM, "5:6: signal Page needs 9 bytes"},
    {"cycle_time_in_words", kMessage + "BA_ \"GenMsgCycleTime\" BO_ 257 \"fast\";\n", kUseOfM,
     "6:31: GenMsgCycleTime of message M is 'fast'"},
    {"texts_without_an_end", kMessage + "VAL_ 257 X 0.5 \"half\" ;\n", "",
     "6:12: expected a raw value or ';'"},
    {"kind_of_a_message_that_there_is_not", "SIG_VALTYPE_ 999 X : 1;\n", "",
     "4:14: SIG_VALTYPE_ is about signal X of the message with id 999, which the file does not "
     "have"},
    {"kind_of_a_signal_that_there_is_not", "SIG_VALTYPE_ 256 X : 1;\n", "",
     "4:14: SIG_VALTYPE_ is about signal X of the message with id 256"},
};

std::string text_with(const Broken& broken) {
    return std::string(kUsed) + broken.lines +
           "BO_ 700 Behind: 8 A\n SG_ Y : 0|8@1+ (1,0) [0|100] \"\" B\n";
}

class BrokenPart : public ::testing::TestWithParam<Broken> {};

TEST_P(BrokenPart, ThatNobodyUsesIsAWarningWithItsPlace) {
    const auto file = parse_dbc(text_with(GetParam()));
    ASSERT_TRUE(file) << file.error().text;
    ASSERT_FALSE(file->warnings.empty());
    const DbcMistake& first = file->warnings.front();
    const std::string told =
        std::to_string(first.line) + ":" + std::to_string(first.column) + ": " + first.text;
    EXPECT_TRUE(told.starts_with(GetParam().warning)) << told;
}

TEST_P(BrokenPart, LeavesTheUsedMessagesAsTheyAre) {
    const std::string text = text_with(GetParam());
    const auto file = parse_dbc(text);
    ASSERT_TRUE(file) << file.error().text;
    const DbcMap map = dbc_map(dbc_settings(text, kUse), SettingScope::input);
    ASSERT_EQ(map.parts.size(), 1U);
    EXPECT_EQ(map.messages[0].id.id, 256U);
    EXPECT_EQ(map.parts[0].channels[0].layout.physical(0xFF38), -100);
    EXPECT_EQ(map.parts[0].channels[1].layout.physical(1000), 1000);
    EXPECT_NE(file->find("Behind"), nullptr);
}

class UsedBrokenPart : public ::testing::TestWithParam<Broken> {};

TEST_P(UsedBrokenPart, IsRefused) {
    const auto map =
        build_dbc_map(dbc_settings(text_with(GetParam()), GetParam().use), SettingScope::input);
    ASSERT_FALSE(map);
    const std::string told = test::told(map.error()).front();
    EXPECT_NE(told.find("cannot be used because of a mistake in line "), std::string::npos) << told;
}

std::vector<Broken> used_parts() {
    std::vector<Broken> used;
    std::ranges::copy_if(kBroken, std::back_inserter(used),
                         [](const Broken& broken) { return !broken.use.empty(); });
    return used;
}

constexpr auto kName = [](const auto& broken) { return std::string(broken.param.name); };
INSTANTIATE_TEST_SUITE_P(Dbc, BrokenPart, ::testing::ValuesIn(kBroken), kName);
INSTANTIATE_TEST_SUITE_P(Dbc, UsedBrokenPart, ::testing::ValuesIn(used_parts()), kName);

TEST(BrokenDbc, ThatEndsWithinAStatementIsRefused) {
    for (const std::string_view end :
         {"BO_ 257 M: 8", "BO_ 257 M: 8 A\n SG_ X : 0|8@1+ (1,0) [0|100] \"", "VAL_ 256 Steer 1",
          "BA_ \"GenMsgCycleTime\" BO_ 256", "SIG_VALTYPE_ 256 Steer :"}) {
        const bool heading = end == "BO_ 257 M: 8";
        EXPECT_EQ(parse_dbc(std::string(kUsed) + std::string(end)).has_value(), heading) << end;
    }
}

/// Nobody can tell which message such a statement is about.
TEST(BrokenDbc, WithAMistakeThatMayBeAboutAnythingIsRefused) {
    for (const std::string_view lines :
         {"SIG_VALTYPE_ x Steer : 1;\n", "BA_DEF_DEF_ \"VFrameFormat\" ;\n", "{}\n"}) {
        EXPECT_FALSE(parse_dbc(std::string(kUsed) + std::string(lines) + "BO_ 3 N: 8 A\n"))
            << lines;
    }
}

TEST(BrokenDbc, OtherSignalsOfAMessageCanBeUsed) {
    const auto broken =
        std::ranges::find(kBroken, "signal_of_1600_bits_beside_others", &Broken::name);
    ASSERT_NE(broken, kBroken.end());
    const std::string text = text_with(*broken);
    const DbcMap map = dbc_map(dbc_settings(text, R"({"M": {"Fine": 1}})"), SettingScope::input);
    EXPECT_EQ(map.parts.at(0).channels.at(0).signal, "Fine");
}

TEST(BrokenDbc, TellsTenMistakesAndTheNumberOfTheOthers) {
    std::string text(kUsed);
    for (int i = 0; i < 25; ++i) {
        text += "BO_ " + std::to_string(300 + i) + " M" + std::to_string(i) + ": 9 A\n";
    }
    const auto warnings = warnings_about_dbc(*parse_dbc(text), "a.dbc");
    ASSERT_EQ(warnings.size(), 11U);
    EXPECT_TRUE(warnings[0].text.starts_with("a.dbc:4:13: message M0 has 9 bytes"))
        << warnings[0].text;
    EXPECT_EQ(warnings[10].text, "a.dbc: and 15 more mistakes in what is not used");
}

}  // namespace
}  // namespace tribus::broken_parts_test
