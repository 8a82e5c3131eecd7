#include "transports/codecs/dbc/map.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string_view>

#include "tests/support/dbc_maps.h"
#include "tests/unit/transports/codecs/dbc/map_bus.h"

/// Maps of messages of J1939.
namespace tribus::map_j1939_test {
namespace {

using namespace test;
using namespace map_bus;

TEST(DbcMap, AJ1939IdMatchesAnyPriorityAndWithAddressFEAnySource) {
    const DbcMap open = map_of(R"({"Joystick": {"X": 1}})", SettingScope::input);
    EXPECT_TRUE(open.messages[0].id.matches(extended_frame(0x18FEDC17, {})));
    EXPECT_FALSE(open.messages[0].id.matches(extended_frame(0x18FEDD17, {})));
    const DbcMap one = map_of(R"({"OneJoystick": {"X1": 1}})", SettingScope::input);
    EXPECT_TRUE(one.messages[0].id.matches(extended_frame(0x18FEDC33, {})));
    EXPECT_FALSE(one.messages[0].id.matches(extended_frame(0x18FEDC17, {})));
}

SettingValues with_own_address(std::string_view signals, std::int64_t address) {
    SettingValues settings = dbc_settings(kBus, signals);
    settings.set("own_address", address);
    return settings;
}

TEST(DbcMap, TheOwnAddressFillsIdsThatTheFileLeavesOpen) {
    // 0x0CFDD6FE (2365512958 without bit 31 is 0x0CFF14FE): the last byte becomes 0x33.
    const DbcMap map =
        dbc_map(with_own_address(R"({"Joystick": {"X": 1}})", 0x33), SettingScope::output);
    const std::uint32_t in_file = 2365512958U & 0x1FFFFFFFU;
    EXPECT_EQ(in_file & 0xFFU, 0xFEU);
    EXPECT_EQ(map.messages.at(0).sent_id, (in_file & ~0xFFU) | 0x33U);
    EXPECT_TRUE(map.messages[0].id.matches({.id = map.messages[0].sent_id, .extended = true}));
    EXPECT_FALSE(map.messages[0].id.matches({.id = in_file, .extended = true}));
}

TEST(DbcMap, TheOwnAddressLeavesOtherIdsAsTheyAre) {
    const DbcMap map =
        dbc_map(with_own_address(R"({"Joystick": {"X": 1}, "Command": {"Speed": 2}})", 0x33),
                SettingScope::output);
    EXPECT_EQ(map.messages.at(1).sent_id, 304U);
}

TEST(DbcMap, AnOwnAddressThatNoIdNeedsIsAMistake) {
    const auto map =
        build_dbc_map(with_own_address(R"({"Command": {"Speed": 2}})", 0x33), SettingScope::output);
    ASSERT_FALSE(map);
    EXPECT_EQ(told(map.error()),
              Lines{"own_address: it is for ids of J1939 that the file leaves at 0xFE, but no "
                    "mapped message has one; leave it out"});
}

}  // namespace
}  // namespace tribus::map_j1939_test
