#include "config/show/json_schema_values.h"

#include <array>
#include <string>
#include <string_view>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tribus::test::json_schema_values_test {
namespace {

using enum SettingType;

constexpr std::array<std::string_view, 2> kWords{"a", "b"};
constexpr std::array<std::string_view, 2> kNumbers{"4", "8"};

std::string schema(const Setting& setting) {
    return value_schema({.setting = setting}).dump();
}

TEST(SchemaOfAValue, IsThatOfItsType) {
    EXPECT_EQ(schema({.key = "k", .type = boolean, .fallback = "true"}),
              R"({"type":"boolean","default":true})");
    EXPECT_EQ(schema({.key = "k", .type = choice, .fallback = "\"b\"", .choices = kWords}),
              R"({"enum":["a","b"],"default":"b"})");
    EXPECT_EQ(schema({.key = "k", .type = text, .fallback = "\"x\""}),
              R"({"type":"string","minLength":1,"default":"x"})");
    EXPECT_EQ(schema({.key = "k", .type = tree}), R"({"type":"object"})");
    EXPECT_EQ(schema({.key = "k", .type = file}), R"({"type":"string","minLength":1})");
    EXPECT_EQ(schema({.key = "k", .type = key_file}), R"({"type":"string","minLength":1})");
}

TEST(SchemaOfAValue, HasThePatternOfItsNotation) {
    EXPECT_EQ(
        schema({.key = "k", .type = duration, .fallback = "\"14ms\"", .least = 0.005, .most = 10}),
        R"({"type":"string","pattern":"^[0-9]+(\\.[0-9]+)?(us|ms|s)$","default":"14ms"})");
    EXPECT_EQ(schema({.key = "k", .type = slew, .fallback = "\"5us/s\""}),
              R"({"type":"string","pattern":"^[0-9]+(\\.[0-9]+)?us/s$","default":"5us/s"})");
    EXPECT_EQ(schema({.key = "interface", .type = text}),
              R"({"type":"string","pattern":"^[^/:\\s]{1,15}$"})");
    EXPECT_EQ(schema({.key = "interfaces", .type = text}), R"({"type":"string","minLength":1})");
}

TEST(SchemaOfAValue, HasTheLimitsOfANumber) {
    EXPECT_EQ(schema({.key = "k", .type = integer, .fallback = "5", .least = 1, .most = 9}),
              R"({"type":"integer","minimum":1,"maximum":9,"default":5})");
    EXPECT_EQ(schema({.key = "k", .type = number, .most = 9}),
              R"({"type":"number","minimum":0,"maximum":9})");
    EXPECT_EQ(schema({.key = "k", .type = pulse, .fallback = "1500", .least = -0.5}),
              R"({"type":"number","minimum":-0.5,"maximum":0,"default":1500})");
    EXPECT_EQ(schema({.key = "k", .type = number}), R"({"type":"number"})");
    EXPECT_EQ(schema({.key = "k", .type = integer, .least = 1, .most = 9, .choices = kNumbers}),
              R"({"enum":[4,8]})");
    EXPECT_EQ(
        schema({.key = "k", .type = pulses, .fallback = "[800, 2200]", .most = 4095}),
        R"({"type":"array","items":{"type":"number","minimum":0,"maximum":4095},"minItems":2,)"
        R"("maxItems":2,"default":[800,2200]})");
}

TEST(SchemaOfAValue, HasTheNamesAndThePointsOfAScale) {
    EXPECT_EQ(schema({.key = "k", .type = scale, .fallback = "\"a\"", .choices = kWords}),
              R"({"anyOf":[{"enum":["a","b"]},{"type":"object","additionalProperties":false,)"
              R"("properties":{"raw":{"type":"array","items":{"type":"integer","minimum":0,)"
              R"("maximum":2047},"minItems":2,"maxItems":2},"us":{"type":"array","items":)"
              R"({"type":"number"},"minItems":2,"maxItems":2}},"required":["raw","us"]}],)"
              R"("default":"a"})");
}

}  // namespace
}  // namespace tribus::test::json_schema_values_test
