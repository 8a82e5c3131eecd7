#include "config/keys/rows.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "config/schema/schema.h"

namespace tribus::test::rows_test {
namespace {

using namespace key_rows;

/// As in a row of the key table. It is no constant, so that rows are made while the test runs.
Setting setting_named(std::string_view key) {
    return {.key = key, .help = "Help", .example = "1"};
}

TEST(RowOfTheKeyTable, TakesItsTypeAndChoicesFromItsMember) {
    const Key priority = row<&RuntimeConfig::priority>(setting_named("priority"));
    EXPECT_EQ(priority.setting.type, SettingType::integer);
    EXPECT_TRUE(priority.setting.choices.empty());
    EXPECT_EQ(priority.name(), "priority");
    EXPECT_EQ(priority.setting.help, "Help");
    EXPECT_EQ(priority.kind, KeyKind::value);
    const Key realtime = row<&RuntimeConfig::realtime>(setting_named("realtime"));
    EXPECT_EQ(realtime.setting.type, SettingType::choice);
    ASSERT_EQ(realtime.setting.choices.size(), 3U);
    EXPECT_EQ(realtime.setting.choices[2], "require");
}

TEST(RowOfTheKeyTable, KeepsTheTypeOfADoubleWhichHasSeveralNotations) {
    Setting setting = setting_named("x");
    setting.type = SettingType::pulse;
    EXPECT_EQ(row<&ConstantConfig::number>(setting).setting.type, SettingType::pulse);
    EXPECT_EQ(row<&ChannelRule::slew_us_per_second>(setting).setting.type, SettingType::pulse);
}

TEST(RowOfTheKeyTable, KeepsChoicesOfItsOwn) {
    constexpr std::array<std::string_view, 1> kFour{"4"};
    Setting setting = setting_named("x");
    setting.type = SettingType::integer;
    setting.choices = kFour;
    const Key key = row<&RuntimeConfig::realtime>(setting);
    EXPECT_EQ(key.setting.type, SettingType::integer);
    ASSERT_EQ(key.setting.choices.size(), 1U);
    EXPECT_EQ(key.setting.choices[0], "4");
}

TEST(RowOfTheKeyTable, SetsAndGetsItsMember) {
    const Key key = row<&RuntimeConfig::priority>(setting_named("priority"));
    RuntimeConfig runtime;
    EXPECT_EQ(key.field.owner, &kOwner<RuntimeConfig>);
    EXPECT_EQ(key.field.initial(), SettingValue(std::int64_t{80}));
    key.field.set(&runtime, SettingValue(std::int64_t{7}));
    EXPECT_EQ(runtime.priority, 7);
    EXPECT_EQ(key.field.get(&runtime), SettingValue(std::int64_t{7}));
}

TEST(RowOfTheKeyTable, SetsAMemberOfAMember) {
    const Key key = row<&OutputConfig::schedule, &ScheduleSettings::period>(setting_named("p"));
    OutputConfig output;
    key.field.set(&output, SettingValue(Duration(5)));
    EXPECT_EQ(output.schedule.period, Duration(5));
    EXPECT_EQ(key.setting.type, SettingType::duration);
}

TEST(RowOfTheKeyTable, HasNoValueForAMemberThatIsEmpty) {
    RuntimeConfig runtime;
    const Key cpu = row<&RuntimeConfig::cpu>(setting_named("cpu"));
    EXPECT_EQ(cpu.field.get(&runtime), std::nullopt);
    cpu.field.set(&runtime, SettingValue(std::int64_t{3}));
    EXPECT_EQ(cpu.field.get(&runtime), SettingValue(std::int64_t{3}));
    RecorderConfig recorder;
    const Key directory = row<&RecorderConfig::directory>(setting_named("directory"));
    EXPECT_EQ(directory.field.get(&recorder), std::nullopt);
    recorder.directory = "/a";
    EXPECT_EQ(directory.field.get(&recorder), SettingValue(std::string("/a")));
}

TEST(RowOfTheKeyTable, WritesPulsesInMicroseconds) {
    ValueRule rule;
    const Key above = row<&ValueRule::above>(setting_named("above"));
    EXPECT_EQ(above.setting.type, SettingType::pulse);
    above.field.set(&rule, SettingValue(1700.5));
    EXPECT_EQ(rule.above, Pulse::from_fractional_microseconds(1700.5));
    EXPECT_EQ(above.field.get(&rule), SettingValue(1700.5));
    const Key between = row<&ValueRule::between>(setting_named("between"));
    EXPECT_EQ(between.setting.type, SettingType::pulses);
    between.field.set(&rule, SettingValue(NumberRange{900, 1100}));
    EXPECT_EQ(rule.between->low, Pulse::from_microseconds(900));
    EXPECT_EQ(rule.between->high, Pulse::from_microseconds(1100));
    EXPECT_EQ(between.field.get(&rule), SettingValue(NumberRange{900, 1100}));
}

TEST(RowOfTheKeyTable, WritesAWordForAnEnumeration) {
    RuntimeConfig runtime;
    const Key key = row<&RuntimeConfig::realtime>(setting_named("realtime"));
    key.field.set(&runtime, SettingValue(std::string("require")));
    EXPECT_EQ(runtime.realtime, Realtime::require);
    EXPECT_EQ(key.field.get(&runtime), SettingValue(std::string("require")));
}

TEST(RowOfAChannel, CountsFromOneAndHasNoDefault) {
    const Key key = channel_row<&HandoverSettings::channel>(setting_named("channel"));
    EXPECT_EQ(key.setting.type, SettingType::integer);
    EXPECT_EQ(key.field.initial, nullptr);
    HandoverSettings handover;
    key.field.set(&handover, SettingValue(std::int64_t{3}));
    EXPECT_EQ(handover.channel, 2U);
    EXPECT_EQ(key.field.get(&handover), SettingValue(std::int64_t{3}));
}

TEST(SettingOfARow, HasTheLimitsOfItsKind) {
    const std::string name = "x";
    const Setting channel = channel_number(name, "Help", "1");
    EXPECT_EQ(channel.type, SettingType::integer);
    EXPECT_EQ(channel.least, 1);
    EXPECT_EQ(channel.most, 18);
    const Setting one = pulse_key(name, "Help", "1500");
    EXPECT_EQ(one.type, SettingType::pulse);
    EXPECT_EQ(one.least, 500);
    EXPECT_EQ(one.most, 2500);
    const Setting two = pulses_key(name, "Help", "[1, 2]", "[3, 4]");
    EXPECT_EQ(two.type, SettingType::pulses);
    EXPECT_EQ(two.least, 0);
    EXPECT_EQ(two.most, 4095);
    EXPECT_EQ(two.fallback, "[3, 4]");
    const Setting table = structure(name, "Help", "{}", "none");
    EXPECT_EQ(table.key, "x");
    EXPECT_EQ(table.help, "Help");
    EXPECT_EQ(table.example, "{}");
    EXPECT_EQ(table.absent, "none");
}

}  // namespace
}  // namespace tribus::test::rows_test
