#include <string>

#include <gtest/gtest.h>

#include "config/language/mistakes.h"
#include "config/load.h"

namespace tribus::many_mistakes_test {
namespace {

/// A pipeline with so many unknown tables beside it.
std::string with_unknown_tables(int count) {
    std::string text =
        "[input.rx]\nprotocol = \"ibus\"\ndevice = \"/dev/a\"\n"
        "[output.o]\nprotocol = \"sbus\"\ndevice = \"/dev/b\"\n"
        "[pipeline.main]\nfrom = \"rx\"\nto = \"o\"\n";
    for (int table = 0; table < count; ++table) {
        text += "[x" + std::to_string(table) + "]\n";
    }
    return text;
}

TEST(ManyMistakes, AreCountedAfterAHundredTexts) {
    const auto mistakes = load_configuration(with_unknown_tables(20'000), "c.toml").error();
    ASSERT_EQ(mistakes.size(), Mistakes::kMostTexts + 1);
    EXPECT_EQ(format_mistake(mistakes.front()).substr(0, 32), "c.toml:10:2: unknown table \"x0\" ");
    EXPECT_EQ(format_mistake(mistakes.back()), "c.toml: and 19,900 more");
}

/// systemd starts the daemon again only if all mistakes may disappear by themselves.
TEST(ManyMistakes, MayBeTemporaryOnlyIfAllAre) {
    Mistakes mistakes("c.toml");
    for (std::size_t line = 0; line < Mistakes::kMostTexts + 5; ++line) {
        mistakes.add_out_of_reach({1, 1}, "absent");
    }
    EXPECT_TRUE(may_be_temporary(mistakes.sorted()));
    mistakes.add({1, 1}, "wrong");
    EXPECT_FALSE(may_be_temporary(mistakes.sorted()));
}

TEST(ManyMistakes, AreCountedWhereKeysAreMissing) {
    std::string text;
    for (int input = 0; input < 150; ++input) {
        text += "[input.i" + std::to_string(input) + "]\n";
    }
    const auto mistakes = load_configuration(text, "c.toml").error();
    ASSERT_EQ(mistakes.size(), Mistakes::kMostTexts + 1);
    EXPECT_EQ(format_mistake(mistakes.back()), "c.toml: and 51 more");
}

}  // namespace
}  // namespace tribus::many_mistakes_test
