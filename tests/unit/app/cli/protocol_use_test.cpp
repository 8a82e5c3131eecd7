#include "app/cli/protocol_use.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/shell.h"
#include "transports/links/can/can_medium.h"
#include "transports/links/serial/serial_medium.h"
#include "transports/registry/registry.h"

namespace tribus::protocol_use_test {
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
    const std::string expected =
        "--protocol: \"sbsu\" is not a known protocol; did you mean \"sbus\"? Allowed: "
        "\"ibus\", \"sbus\", ";
    EXPECT_EQ(refusal("sbsu", {}).substr(0, expected.size()), expected);
}

std::vector<std::string_view> names_of_auto(const GivenSettings& given) {
    std::vector<std::string_view> names;
    const auto uses = choose_protocols("auto", SettingScope::input, given);
    EXPECT_TRUE(uses) << uses.error();
    for (const ProtocolUse& use : uses.value_or(std::vector<ProtocolUse>{})) {
        names.push_back(use.protocol->name);
    }
    return names;
}

bool auto_has(std::string_view protocol, const GivenSettings& given) {
    const auto names = names_of_auto(given);
    return std::ranges::find(names, protocol) != names.end();
}

// DBC has required settings.
TEST(ProtocolUse, AutoIsEveryProtocolThatAllowsTheSettings) {
    EXPECT_TRUE(auto_has("ibus", {{"scale", "futaba"}}));
    EXPECT_TRUE(auto_has("sbus", {{"scale", "futaba"}}));
    EXPECT_TRUE(auto_has("can", {{"scale", "futaba"}}));
    EXPECT_FALSE(auto_has("dbc", {{"scale", "futaba"}}));
    EXPECT_FALSE(auto_has("dronecan", {{"scale", "futaba"}})) << "its scale has other words";
    EXPECT_TRUE(auto_has("ibus", {{"baud", "115200"}}));
    EXPECT_FALSE(auto_has("sbus", {{"baud", "115200"}}));
}

TEST(ProtocolUse, AutoRefusesASettingThatNoProtocolAllows) {
    EXPECT_EQ(refusal("auto", {{"scale", "futuba"}}).substr(0, 20), "--scale is \"futuba\";");
    EXPECT_EQ(refusal("auto", {{"dbc", "/nonexistent/file.dbc"}, {"signals", "{}"}}).substr(0, 5),
              "--dbc");
}

TEST(ProtocolUse, AutoIsSilentOfProtocolsThatCannotBeRead) {
    EXPECT_EQ(refusal("auto", {{"id", "first"}}).substr(0, 5), "--id ");
}

TEST(ProtocolUse, AProtocolThatOnlySendsCannotBeRead) {
    EXPECT_EQ(refusal("sensors", {{"sensor_bus", "probes"}}),
              "--protocol sensors: protocol \"sensors\" only sends; allowed: in an output");
}

TEST(ProtocolUse, AProtocolOfValuesThatOnlySendsCannotBeRead) {
    const auto uses = choose_protocols("exbus-telemetry", SettingScope::input, {});
    ASSERT_FALSE(uses);
    EXPECT_EQ(uses.error(),
              "--protocol exbus-telemetry: protocol \"exbus-telemetry\" only sends; allowed: in "
              "an output");
    EXPECT_EQ(protocol_list(SettingScope::input).find("exbus-telemetry"), std::string::npos);
    EXPECT_NE(protocol_list(SettingScope::input).find("crsf-telemetry"), std::string::npos);
    EXPECT_NE(protocol_list(SettingScope::input).find("ibus-sensor"), std::string::npos);
}

TEST(ProtocolUse, AProtocolThatOnlyReceivesCannotBeWritten) {
    const auto uses = choose_protocols("fport", SettingScope::output, {});
    ASSERT_FALSE(uses);
    EXPECT_EQ(uses.error(),
              "--protocol fport: protocol \"fport\" only receives; allowed: in an input");
    EXPECT_EQ(protocol_list(SettingScope::output).find("fport"), std::string::npos);
}

TEST(ProtocolUse, ListsTheProtocolsOfOneKindOfLink) {
    EXPECT_TRUE(protocol_list(kSerialMedium).starts_with("ibus, sbus"));
    EXPECT_TRUE(protocol_list(kCanMedium).starts_with("can, dbc, sensors, dronecan"));
}

TEST(ProtocolUse, NumbersMayBeHexadecimal) {
    const auto use = use_protocol(*find_protocol("can"), SettingScope::input, {{"id", "0x123"}});
    ASSERT_TRUE(use) << use.error();
    EXPECT_EQ(use->settings.get_or<std::int64_t>("id", 0), 0x123);
}

TEST(ProtocolUse, SettingsThatDoNotGoTogetherAreRefused) {
    const std::string text = refusal("can", {{"fd", "true"}, {"crc", "p01"}});
    EXPECT_EQ(text.substr(0, 41), "--crc: \"p01\" is for classic frames; FD fr");
}

TEST(ProtocolUse, SettingThatIsMissingIsNamed) {
    EXPECT_EQ(refusal("dbc", {}).substr(0, 23), "--dbc: dbc requires it:");
}

// Two channels of 16 bits, as the manufacturer of a rover might describe them.
TEST(ProtocolUse, FileAndTreeMayBeGivenAsInTheConfiguration) {
    const test::TemporaryFolder folder;
    const std::string dbc = folder.write("sticks.dbc",
                                         "BO_ 512 Sticks: 4 Node\n"
                                         " SG_ Steer : 0|16@1+ (1,0) [0|65535] \"us\" Node\n"
                                         " SG_ Speed : 16|16@1+ (1,0) [0|65535] \"us\" Node\n");
    const auto use = use_protocol(*find_protocol("dbc"), SettingScope::input,
                                  {{"dbc", dbc}, {"signals", "{ Sticks.Steer = 1 }"}});
    ASSERT_TRUE(use) << use.error();
    EXPECT_NE(use->settings.find_as<SettingFile>("dbc"), nullptr);
    EXPECT_NE(use->settings.find_as<SettingTree>("signals"), nullptr);
    EXPECT_EQ(refusal("dbc", {{"dbc", dbc}, {"signals", "{ Sticks.Stear = 1 }"}}).substr(0, 24),
              "--signals.Sticks.Stear: ");
}

TEST(ProtocolUse, DeviceSettingsAreNoOptions) {
    GivenSettings given;
    for (const CommandOption& option : setting_options(SettingScope::input, "", given)) {
        EXPECT_NE(option.name, "--inverted");
    }
}

}  // namespace
}  // namespace tribus::protocol_use_test
