#include "config/show/manual_text.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::test::manual_text_test {
namespace {

/// `p`, `l` or `c` for each block, and its texts between bars.
std::vector<std::string> blocks(std::string_view text) {
    std::vector<std::string> shown;
    for (const ManualBlock& block : blocks_of(text)) {
        std::string& one = shown.emplace_back(1, "plc"[static_cast<std::size_t>(block.kind)]);
        for (const std::string& line : block.texts) {
            one += "|" + line;
        }
    }
    return shown;
}

using Blocks = std::vector<std::string>;

TEST(BlocksOfATextOfTheManual, AreParagraphs) {
    EXPECT_EQ(blocks(""), Blocks{});
    EXPECT_EQ(blocks("\n\n"), Blocks{});
    EXPECT_EQ(blocks("One"), Blocks{"p|One"});
    EXPECT_EQ(blocks("\nOne\nmore.\n\n\nTwo\n"), (Blocks{"p|One more.", "p|Two"}));
    EXPECT_EQ(blocks("One\n   more"), Blocks{"p|One more"});
}

TEST(BlocksOfATextOfTheManual, AreLists) {
    EXPECT_EQ(blocks("- a\n  b\n- c"), Blocks{"l|a b|c"});
    EXPECT_EQ(blocks("One\n\n- a\n\n- b\n\nTwo -\n"), (Blocks{"p|One", "l|a", "l|b", "p|Two -"}));
    EXPECT_EQ(blocks("-a"), Blocks{"p|-a"});
}

TEST(BlocksOfATextOfTheManual, AreCode) {
    EXPECT_EQ(blocks("```toml\n- a = 1\n\n  b\n```\nBehind\nit"),
              (Blocks{"c|- a = 1||  b", "p|Behind it"}));
    EXPECT_EQ(blocks("Before\n```\nx\n```\n- item\n```\n```\n"),
              (Blocks{"p|Before", "c|x", "l|item", "c"}));
}

TEST(ReplacedText, IsReplacedEverywhere) {
    EXPECT_EQ(replaced("aXbXXc", "X", "YX"), "aYXbYXYXc");
    EXPECT_EQ(replaced("**a** b", "**", ""), "a b");
    EXPECT_EQ(replaced("aaa", "aa", "b"), "ba");
    EXPECT_EQ(replaced("abc", "x", "y"), "abc");
    EXPECT_EQ(replaced("Xa", "X", ""), "a");
}

}  // namespace
}  // namespace tribus::test::manual_text_test
