#include "app/protocol_use.h"

#include <cstdint>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "transports/registry/registry.h"

namespace tribus {
namespace {

std::string refusal(std::string_view name, const GivenSettings& given) {
    const auto uses = choose_protocols(name, SettingScope::input, given);
    EXPECT_FALSE(uses);
    return uses ? std::string() : uses.error();
}

TEST(ProtocolUse, FillsInTheDefaults) {
    const auto use = use_protocol(*find_protocol("sbus"), SettingScope::input, {});
    ASSERT_TRUE(use) << use.error();
    EXPECT_EQ(use->line, find_protocol("sbus")->line);
    EXPECT_EQ(use->settings.get_or<std::string>("scale", ""), "betaflight");
}

TEST(ProtocolUse, BaudChangesTheLine) {
    const auto use =
        use_protocol(*find_protocol("sbus"), SettingScope::input, {{"baud", "200000"}});
    ASSERT_TRUE(use) << use.error();
    EXPECT_EQ(use->line.baud, 200000U);
    EXPECT_EQ(use->line.parity, Parity::even);
}

TEST(ProtocolUse, ScaleMayBeTwoPointsAsInTheConfiguration) {
    const auto use = use_protocol(*find_protocol("sbus"), SettingScope::input,
                                  {{"scale", "{ raw = [172, 1811], us = [988, 2012] }"}});
    ASSERT_TRUE(use) << use.error();
    const auto* points = use->settings.find_as<TwoPoints>("scale");
    ASSERT_NE(points, nullptr);
    EXPECT_EQ(points->raw[1], 1811);
    EXPECT_EQ(points->microseconds[0], 988);
}

TEST(ProtocolUse, RefusesValuesThatAreNotAllowed) {
    EXPECT_EQ(refusal("sbus", {{"baud", "115200"}}), "--baud is 115200; allowed: 100000, 200000");
    EXPECT_EQ(refusal("sbus", {{"scale", "futuba"}}).substr(0, 20), "--scale is \"futuba\";");
}

TEST(ProtocolUse, RefusesSettingsOfOtherProtocolsAndOfTheOtherDirection) {
    EXPECT_EQ(refusal("ibus", {{"scale", "futaba"}}),
              "--scale: ibus has no such setting; leave it out");
    EXPECT_EQ(refusal("ibus", {{"channels", "18"}}),
              "--channels: ibus has no such setting; leave it out");
}

TEST(ProtocolUse, NamesTheProtocolThatWasMeant) {
    EXPECT_EQ(refusal("sbsu", {}),
              "--protocol: \"sbsu\" is no protocol that is known; did you mean \"sbus\"? Allowed: "
              "\"ibus\", \"sbus\"");
}

TEST(ProtocolUse, AutoIsEveryProtocolThatAllowsTheSettings) {
    const auto all = choose_protocols("auto", SettingScope::input, {{"scale", "futaba"}});
    ASSERT_TRUE(all) << all.error();
    EXPECT_EQ(all->size(), protocols().size());
    const auto at_115200 = choose_protocols("auto", SettingScope::input, {{"baud", "115200"}});
    ASSERT_TRUE(at_115200) << at_115200.error();
    ASSERT_EQ(at_115200->size(), 1U);
    EXPECT_EQ(at_115200->front().protocol->name, "ibus");
}

TEST(ProtocolUse, DeviceSettingsAreNoOptions) {
    for (const SettingOption& option : setting_options(SettingScope::input)) {
        EXPECT_NE(option.key, "inverted");
    }
}

}  // namespace
}  // namespace tribus
