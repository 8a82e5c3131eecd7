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

}  // namespace
}  // namespace tribus::paragraph_test
