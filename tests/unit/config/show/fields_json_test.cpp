#include "config/show/fields_json.h"

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tribus::test::fields_json_test {
namespace {

using enum SettingType;

TEST(NumberInJson, HasNoPointIfItIsWhole) {
    EXPECT_EQ(number_json(2).dump(), "2");
    EXPECT_EQ(number_json(-2).dump(), "-2");
    EXPECT_EQ(number_json(0.5).dump(), "0.5");
    EXPECT_EQ(number_json(-0.25).dump(), "-0.25");
    EXPECT_EQ(number_json(999'999'999'999'999.0).dump(), "999999999999999");
    EXPECT_EQ(number_json(1e15).dump(), "1e+15");
    EXPECT_EQ(number_json(-1e15).dump(), "-1e+15");
}

std::string shown(SettingType type, const SettingValue& value) {
    return value_json(type, value).dump();
}

TEST(ValueInJson, IsInTheNotationOfAFile) {
    EXPECT_EQ(shown(boolean, true), "true");
    EXPECT_EQ(shown(integer, std::int64_t{-5}), "-5");
    EXPECT_EQ(shown(number, 1500.0), "1500");
    EXPECT_EQ(shown(pulse, 0.5), "0.5");
    EXPECT_EQ(shown(slew, 2000.0), "\"2000us/s\"");
    EXPECT_EQ(shown(text, std::string("a")), "\"a\"");
    EXPECT_EQ(shown(duration, Duration(std::chrono::milliseconds(14))), "\"14ms\"");
    EXPECT_EQ(shown(pulses, NumberRange{800, 2200.5}), "[800,2200.5]");
    EXPECT_EQ(shown(scale, TwoPoints{{172, 1811}, {988.5, 2012}}),
              R"({"raw":[172,1811],"us":[988.5,2012]})");
    EXPECT_EQ(shown(file, SettingFile{"bus.dbc", "BO_"}), "\"bus.dbc\"");
    EXPECT_EQ(shown(key_file, KeyFile{"a.key", {7}}), "\"a.key\"");
}

TEST(ValueInJson, IsATreeAsItWasWritten) {
    const SettingTree tree{
        SettingTree::Table{{"z", {true}},
                           {"a", {SettingTree::List{{std::int64_t{1}}, {2.0}, {std::string("x")}}}},
                           {"m", {SettingTree::Table{}}},
                           {"l", {SettingTree::List{}}}}};
    EXPECT_EQ(shown(SettingType::tree, tree), R"({"z":true,"a":[1,2.0,"x"],"m":{},"l":[]})");
}

const std::vector<Key> kRows{{.setting = {.key = "b", .type = integer}},
                             {.setting = {.key = "a", .type = slew}},
                             {.setting = {.key = "c"}}};

TEST(ValuesInJson, AreInTheOrderOfTheRows) {
    SettingValues values;
    values.set("a", 5.0);
    values.set("x", true);
    values.set("b", std::int64_t{7});
    EXPECT_EQ(values_json(values, kRows).dump(), R"({"b":7,"a":"5us/s"})");
    EXPECT_EQ(values_json({}, kRows).dump(), "{}");
}

TEST(MembersInJson, AreThoseThatRowsOfTheirOwnerName) {
    RuntimeConfig runtime;
    runtime.priority = 7;
    EXPECT_EQ(fields_json(runtime, runtime_keys()).dump(),
              R"({"realtime":"auto","priority":7,"spin":"0s"})");
    runtime.cpu = 2;
    EXPECT_EQ(fields_json(runtime, runtime_keys()).dump(),
              R"({"realtime":"auto","priority":7,"cpu":2,"spin":"0s"})");
    EXPECT_EQ(fields_json(runtime, recorder_keys()).dump(), "{}");
    EXPECT_EQ(fields_json(runtime, kRows).dump(), "{}");
}

TEST(JsonInTheOrderOfRows, HasWhatIsNoRowBehindThem) {
    const auto json = nlohmann::ordered_json::parse(R"({"y":1,"c":2,"x":3,"b":4})");
    EXPECT_EQ(in_order_of_rows(json, kRows).dump(), R"({"b":4,"c":2,"y":1,"x":3})");
}

TEST(JsonInTheOrderOfRows, LacksWhatIsNotWanted) {
    const auto json = nlohmann::ordered_json::parse(R"({"y":1,"c":2,"x":3,"b":4})");
    EXPECT_EQ(
        in_order_of_rows(json, kRows, [](std::string_view key) { return key != "c" && key != "x"; })
            .dump(),
        R"({"b":4,"y":1})");
}

}  // namespace
}  // namespace tribus::test::fields_json_test
