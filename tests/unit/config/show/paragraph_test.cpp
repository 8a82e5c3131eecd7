#include "config/show/paragraph.h"

#include <gtest/gtest.h>

namespace tribus::paragraph_test {
namespace {

TEST(Paragraph, BreaksAtBlanks) {
    EXPECT_EQ(paragraph("# ", "# ", "one two three four", 10), "# one two\n# three\n# four\n");
}

TEST(Paragraph, FillsALineToItsLastColumn) {
    EXPECT_EQ(paragraph("", "", "12345 789 x", 9), "12345 789\nx\n");
}

TEST(Paragraph, LeavesALongWordAloneInALine) {
    EXPECT_EQ(paragraph("- ", "  ", "a /dev/serial/by-id/usb b", 10),
              "- a\n  /dev/serial/by-id/usb\n  b\n");
}

TEST(Paragraph, IsWhatStandsInFrontIfItHasNoText) {
    EXPECT_EQ(paragraph("> ", "  ", "", 10), "> \n");
}

TEST(Paragraph, CountsWhatStandsInFrontOfEachLine) {
    EXPECT_EQ(paragraph("", "    ", "aa bb cc dd ee ff", 9), "aa bb cc\n    dd ee\n    ff\n");
    EXPECT_EQ(paragraph("    ", "", "aa bb cc dd ee", 9), "    aa bb\ncc dd ee\n");
    EXPECT_EQ(paragraph("12345678", "", "aa bb", 9), "12345678aa\nbb\n");
    EXPECT_EQ(paragraph("", "", "aa bb cc dd ee ff", 5), "aa bb\ncc dd\nee ff\n");
}

}  // namespace
}  // namespace tribus::paragraph_test
