#include "config/show/write_toml.h"

#include <array>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace tribus::test::write_toml_test {
namespace {

Key table(std::string_view name, std::span<const Key> inside = {}, KeyKind kind = KeyKind::table) {
    return {.setting = {.key = name}, .kind = kind, .inside = inside};
}

const std::array kDeeper{table("deeper")};
const std::array kRoot{table("table", kDeeper), table("named", kDeeper, KeyKind::named_tables),
                       table("channels", kDeeper, KeyKind::channels),
                       table("list", {}, KeyKind::list), table("preset", {}, KeyKind::presets)};

std::string toml(const std::string& json) {
    return write_toml(nlohmann::ordered_json::parse(json), kRoot);
}

TEST(WriteToml, WritesEachValueInOneLine) {
    EXPECT_EQ(toml(R"({"table":{"whole":-1,"half":0.5,"truth":true,"text":"a\"b\\",
                   "list":[1,"x",[false,[]]],"inner":{"a":1,"b":{"c":"d"},"e":[{"f":2}]},
                   "empty":{},"none":[]}})"),
              R"([table]
whole = -1
half = 0.5
truth = true
text = "a\"b\\"
list = [1, "x", [false, []]]
inner = { a = 1, b = { c = "d" }, e = [{ f = 2 }] }
empty = { }
none = []
)");
}

TEST(WriteToml, WritesTablesBehindTheLinesOfTheirTable) {
    EXPECT_EQ(toml(R"({"table":{"a":1,"deeper":{"x":2},"b":3}})"),
              "[table]\na = 1\nb = 3\n\n[table.deeper]\nx = 2\n");
}

TEST(WriteToml, WritesNoHeaderForATableWithoutLines) {
    EXPECT_EQ(toml(R"({"table":{"deeper":{"x":2}}})"), "[table.deeper]\nx = 2\n");
    EXPECT_EQ(toml(R"({"table":{}})"), "");
    EXPECT_EQ(toml("{}"), "");
}

TEST(WriteToml, WritesATableForEachName) {
    EXPECT_EQ(toml(R"({"named":{"b":{"x":1,"deeper":{"y":2}},"a":{"x":3}}})"),
              "[named.b]\nx = 1\n\n[named.b.deeper]\ny = 2\n\n[named.a]\nx = 3\n");
}

TEST(WriteToml, WritesEachChannelInOneLine) {
    EXPECT_EQ(toml(R"({"channels":{"1":2,"2":{"from":3},"deeper":{"x":1}}})"),
              "[channels]\n1 = 2\n2 = { from = 3 }\ndeeper = { x = 1 }\n");
}

TEST(WriteToml, WritesListsAndPresetsInOneLine) {
    EXPECT_EQ(toml(R"({"list":[{"a":1},{"b":2}],"preset":{"3":988,"other":1500}})"),
              "[]\nlist = [{ a = 1 }, { b = 2 }]\npreset = { 3 = 988, other = 1500 }\n");
}

}  // namespace
}  // namespace tribus::test::write_toml_test
