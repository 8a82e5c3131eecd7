#include "app/cli/screen_parts.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

namespace tribus::test::screen_parts_test {
namespace {

using namespace std::chrono_literals;

TEST(ShortDuration, HasThreeFiguresAtMost) {
    EXPECT_EQ(short_duration(34us), "34 us");
    EXPECT_EQ(short_duration(2400us), "2.4 ms");
    EXPECT_EQ(short_duration(98ms), "98 ms");
    EXPECT_EQ(short_duration(1250ms), "1.25 s");
}

std::string line_of(std::size_t columns, bool unicode, const std::vector<std::string>& texts,
                    bool colour = false) {
    const ScreenStyle style{.columns = columns, .unicode = unicode, .colour = colour};
    screen::Line line(style);
    for (const std::string& text : texts) {
        line.add(text, screen::kRed);
    }
    return line.take();
}

TEST(ScreenLine, MarksWhatItCuts) {
    EXPECT_EQ(line_of(8, true, {"receiver2"}), "receive…");
    EXPECT_EQ(line_of(8, false, {"receiver2"}), "receive>");
    EXPECT_EQ(line_of(8, false, {"receiver", "2"}), "receive>");
    EXPECT_EQ(line_of(8, true, {"m\xC3\xBCllerei", "er"}), "m\xC3\xBCllere…");
    EXPECT_EQ(line_of(1, true, {"ab"}), "…");
    EXPECT_EQ(line_of(0, true, {"ab"}), "");
}

TEST(ScreenLine, MarksNothingIfOnlyBlanksAreCut) {
    EXPECT_EQ(line_of(8, true, {"receiver", "  "}), "receiver");
    EXPECT_EQ(line_of(8, true, {"receiver"}), "receiver");
    EXPECT_EQ(line_of(8, true, {"receiver", "  ", "2"}), "receive…");
}

TEST(ScreenLine, KeepsItsColoursWhereItIsCut) {
    EXPECT_EQ(line_of(3, true, {"ab", "cde"}, true), "\x1b[31mab\x1b[0m\x1b[31m…\x1b[0m");
}

}  // namespace
}  // namespace tribus::test::screen_parts_test
