#include "app/bench/table.h"

#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::bench::bench_table_test {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) {
        lines.push_back(line);
    }
    return lines;
}

const std::vector<Row> kRows{
    {.what = "A heading that is rather longer than a table of this width has room for in a line"},
    {.what = "p99",
     .figure = "1.23ms",
     .anchor = "987us",
     .ratio = 1.246,
     .reading = "nearly as good as a bare relay, whatever the machine does meanwhile"},
    {.what = "something-without-any-space-that-is-longer-than-its-column", .figure = "3"}};

class TableWidth : public testing::TestWithParam<std::size_t> {};

TEST_P(TableWidth, IsKeptByEveryLine) {
    for (const std::string& line : lines_of(draw_table(kRows, GetParam()))) {
        EXPECT_LE(line.size(), GetParam()) << line;
        EXPECT_FALSE(line.ends_with(' ')) << line;
    }
}

INSTANTIATE_TEST_SUITE_P(Columns, TableWidth, testing::Values(60, 80, 100));

TEST(Table, HasEveryWordOfEveryCell) {
    const std::string table = draw_table(kRows, 80);
    for (const char* word :
         {"heading", "line", "p99", "1.23ms", "987us", "1.25", "relay,", "meanwhile"}) {
        EXPECT_NE(table.find(word), std::string::npos) << word;
    }
}

TEST(Table, PutsFigureAnchorAndRatioIntoColumns) {
    const std::vector<Row> rows{
        {.what = "p50", .figure = "42us", .anchor = "40us", .ratio = 1.05, .reading = "good"}};
    EXPECT_EQ(lines_of(draw_table(rows, 80)).back(),
              "p50                         42us      40us   1.05  good");
}

TEST(Table, KeepsToItsLeastWidthWhereLessIsAsked) {
    EXPECT_EQ(draw_table(kRows, 10), draw_table(kRows, kLeastTableColumns));
}

TEST(Reading, IsAsGoodWithinATenthAndTheNoise) {
    EXPECT_EQ(reading_of(1.08, 1, "a relay"), "as good as a relay");
    EXPECT_EQ(reading_of(1.20, 1.1, "a relay"), "as good as a relay");
}

TEST(Reading, TellsBetterNearlyAndWorse) {
    EXPECT_EQ(reading_of(0.5, 1, "a relay"), "better than a relay");
    EXPECT_EQ(reading_of(1.4, 1, "a relay"), "nearly as good as a relay");
    EXPECT_EQ(reading_of(3, 1, "a relay"), "worse than a relay");
}

}  // namespace
}  // namespace tribus::bench::bench_table_test
