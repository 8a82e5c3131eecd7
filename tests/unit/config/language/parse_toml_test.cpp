#include "config/language/parse_toml.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace tribus::test::parse_toml_test {
namespace {

Table parsed(std::string_view text) {
    auto table = parse_toml(text);
    EXPECT_TRUE(table) << table.error().text;
    return table ? *table : Table{};
}

/// `KEY LINE:COLUMN (of the key) LINE:COLUMN (of the value) VALUE` for each entry.
std::vector<std::string> entries(const Table& table) {
    std::vector<std::string> lines;
    for (const Entry& entry : table.entries) {
        lines.push_back(fmt::format("{} {}:{} {}:{} {}", entry.key, entry.where.line,
                                    entry.where.column, entry.value.where.line,
                                    entry.value.where.column, describe(entry.value)));
    }
    return lines;
}

TEST(ParseToml, KeepsTheOrderOfTheFileAndThePlaces) {
    EXPECT_EQ(entries(parsed("z = true\n  b = 5 \na = 0.5\nd = \"x\"\nc = 1979-05-27\n")),
              (std::vector<std::string>{"z 1:1 1:5 true", "b 2:3 2:7 5", "a 3:1 3:5 0.5",
                                        "d 4:1 4:5 \"x\"", "c 5:1 5:5 a date or time"}));
    const Table table = parsed("t = { z = 1, y = { }, x = 2 }\n");
    EXPECT_EQ(entries(*table.entries[0].value.as<Table>()),
              (std::vector<std::string>{"z 1:7 1:11 1", "y 1:14 1:18 a table", "x 1:23 1:27 2"}));
}

TEST(ParseToml, TellsListsOfHeadersFromOthers) {
    const auto of_headers = [](std::string_view text) {
        return parsed(text).entries[0].value.as<List>()->of_headers;
    };
    EXPECT_TRUE(of_headers("[[a]]\nb = 1\n"));
    EXPECT_FALSE(of_headers("a = [{ b = 1 }]"));
    EXPECT_FALSE(of_headers("a = [1]"));
    EXPECT_FALSE(of_headers("a = []"));
}

TEST(ParseToml, KeepsEveryItemOfAList) {
    EXPECT_EQ(describe(parsed("a = [1, \"b\", false]").entries[0].value), "[1, \"b\", false]");
}

std::string error(std::string_view text) {
    const auto table = parse_toml(text);
    EXPECT_FALSE(table) << text;
    return table ? ""
                 : fmt::format("{}:{} {} {}", table.error().where.line, table.error().where.column,
                               table.error().whole, table.error().text);
}

TEST(ParseToml, TellsWhereATextIsWrongInOneLine) {
    EXPECT_EQ(error("a = 1\n b =\n"),
              "2:5 false Error while parsing key-value pair: expected value, saw '\\n'");
}

TEST(ParseToml, TellsOfAKeyOfTooManyParts) {
    EXPECT_EQ(error("b.b.b.b.b.b.b.b.b.b.b.b.b.b.b.b.b = 1"),
              "1:33 true this key has too many parts; allowed: at most 16");
}

TEST(ParseToml, TellsOfADepthThatNothingNeeds) {
    const std::string text = error("b = " + std::string(60, '['));
    EXPECT_EQ(text.substr(text.find(' ')),
              " true more than 32 nested lists and tables; a configuration needs only a few");
}

TEST(EntryOfATable, IsFoundByItsKey) {
    const Table table = parsed("a = 1\nb = 2\n");
    EXPECT_EQ(table.find("b"), &table.entries[1]);
    EXPECT_EQ(table.find("c"), nullptr);
    EXPECT_EQ(table.find(""), nullptr);
}

TEST(DescribedValue, IsAsItStandsInTheFileIfThatIsShort) {
    const auto described = [](const std::string& value) {
        return describe(parsed("a = " + value).entries[0].value);
    };
    for (const std::string value :
         {"true", "false", "-20", "0.5", "\"abc\"", "[1]", "[1, \"b\", 0.5, true]"}) {
        EXPECT_EQ(described(value), value);
    }
    EXPECT_EQ(described("2.0"), "2");
    for (const std::string value :
         {"[]", "[1, 2, 3, 4, 5]", "[[1]]", "[{}]", "[1979-05-27]", "[1, [2]]"}) {
        EXPECT_EQ(described(value), "a list") << value;
    }
    EXPECT_EQ(described("{ b = 1 }"), "a table");
    EXPECT_EQ(described("07:32:00"), "a date or time");
    const std::string eighty(80, 'x');
    EXPECT_EQ(described("\"" + eighty + "\""), "\"" + eighty + "\"");
    EXPECT_EQ(described("\"" + eighty + "y\""), "\"" + eighty + "\"...");
}

}  // namespace
}  // namespace tribus::test::parse_toml_test
