#include "config/show/paragraph.h"

#include <gtest/gtest.h>

namespace tribus::paragraph_test {
namespace {

TEST(Paragraph, breaks_at_blanks) {
    EXPECT_EQ(paragraph("# ", "# ", "one two three four", 10), "# one two\n# three\n# four\n");
}

TEST(Paragraph, fills_a_line_to_its_last_column) {
    EXPECT_EQ(paragraph("", "", "12345 789 x", 9), "12345 789\nx\n");
}

TEST(Paragraph, leaves_a_long_word_alone_in_a_line) {
    EXPECT_EQ(paragraph("- ", "  ", "a /dev/serial/by-id/usb b", 10),
              "- a\n  /dev/serial/by-id/usb\n  b\n");
}

TEST(Paragraph, of_nothing_is_what_stands_in_front) {
    EXPECT_EQ(paragraph("> ", "  ", "", 10), "> \n");
}

}  // namespace
}  // namespace tribus::paragraph_test
