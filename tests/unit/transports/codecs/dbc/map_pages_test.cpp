#include "transports/codecs/dbc/map.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "tests/support/dbc_maps.h"
#include "tests/unit/transports/codecs/dbc/map_bus.h"

/// Maps of multiplexed messages.
namespace tribus::map_pages_test {
namespace {

using namespace test;
using namespace map_bus;

TEST(DbcMap, EachPageIsAFrameThatIsSent) {
    const DbcMap map = map_of(R"({"Paged": {"First": 1, "Second": 2}})");
    ASSERT_EQ(map.parts.size(), 2U);
    EXPECT_EQ(map.parts[0].selectors.at(0).sent, 0U);
    EXPECT_EQ(map.parts[1].selectors.at(0).sent, 1U);
}

constexpr std::string_view kUnknownPage =
    "the DBC file says that it is multiplexed, but not by which signal or with which values of it; "
    "allowed: a signal marked m0, m1, ... in a message with one signal marked M, or one with a "
    "range in SG_MUL_VAL_";

constexpr std::string_view kHalfMultiplexed = R"(
BO_ 1 M: 8 A
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" B
 SG_ Bare m : 8|8@1+ (1,0) [0|100] "" B
 SG_ Known m1 : 8|8@1+ (1,0) [0|100] "" B
 SG_ Sign m : 16|1@1+ (1,0) [0|0] "" B
 SG_ Always : 24|8@1+ (1,0) [0|100] "" B
BO_ 2 N: 8 A
 SG_ Alone m1M : 0|8@1+ (1,0) [0|100] "" B
 SG_ Below : 8|8@1+ (1,0) [0|100] "" B
SG_MUL_VAL_ 2 Below Alone 3-3;
)";

TEST(DbcMap, RefusesASignalWhosePageTheFileDoesNotSay) {
    for (const SettingScope scope : {SettingScope::input, SettingScope::output}) {
        EXPECT_EQ(mistakes_of_signals(kHalfMultiplexed, R"({"M": {"Bare": 1}})", scope),
                  Lines{"signals.M.Bare: " + std::string(kUnknownPage)});
        EXPECT_EQ(mistakes_of_signals(kHalfMultiplexed, R"({"N": {"Below": 1}})", scope),
                  Lines{"signals.N.Below: " + std::string(kUnknownPage)});
    }
}

TEST(DbcMap, TakesTheOtherSignalsOfTheSameMessage) {
    EXPECT_EQ(mistakes_of_signals(kHalfMultiplexed, R"({"M": {"Known": 1}})"), Lines{});
    EXPECT_EQ(mistakes_of_signals(kHalfMultiplexed, R"({"M": {"Always": 1}})"), Lines{});
}

TEST(DbcMap, RefusesADirectionWhosePageTheFileDoesNotSay) {
    EXPECT_EQ(
        mistakes_of_signals(kHalfMultiplexed,
                            R"({"M": {"Always": {"channel": 1, "negative": "Sign"}}})"),
        Lines{
            "signals.M.Always.negative: \"Sign\" cannot give the direction of \"Always\"; allowed: "
            "another signal of 1 or 2 bits in the same frames"});
}

TEST(DbcMap, AFixedSelectorSaysWhichPageIsSent) {
    const DbcMap map = map_of(R"({"Paged": {"Page": {"fixed": 1}, "Second": 2}})");
    ASSERT_EQ(map.parts.size(), 1U);
    EXPECT_TRUE(map.parts[0].fixed.empty());
    EXPECT_EQ(map.parts[0].selectors.at(0).sent, 1U);
    EXPECT_EQ(map.parts[0].channels.at(0).signal, "Second");
}

TEST(DbcMap, AFixedSelectorChoosesOneOfSeveralPagesOfASignal) {
    constexpr std::string_view kRange = R"(BO_ 1 M: 3 A
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" B
 SG_ X m1 : 8|8@1+ (1,0) [0|100] "" B
SG_MUL_VAL_ 1 X Page 1-3;
)";
    for (const SettingScope scope : {SettingScope::input, SettingScope::output}) {
        const DbcMap map =
            dbc_map(dbc_settings(kRange, R"({"M": {"Page": {"fixed": 2}, "X": 1}})"), scope);
        const DbcSelector& selector = map.parts.at(0).selectors.at(0);
        EXPECT_EQ(selector.sent, 2U);
        EXPECT_EQ(selector.selected_by, (std::vector<DbcSelectorRange>{{2, 2}}));
    }
}

TEST(DbcMap, AFixedSelectorSaysWhichPageIsReadAndOthersAreNoFault) {
    const DbcMap map =
        map_of(R"({"Paged": {"Page": {"fixed": 1}, "Second": 2}})", SettingScope::input);
    ASSERT_EQ(map.parts.size(), 1U);
    EXPECT_TRUE(map.parts[0].fixed.empty());
    EXPECT_EQ(map.parts[0].selectors.at(0).selected_by, (std::vector<DbcSelectorRange>{{1, 1}}));
}

}  // namespace
}  // namespace tribus::map_pages_test
