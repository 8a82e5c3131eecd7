#include "config/language/typography.h"

#include <string>

#include <gtest/gtest.h>

namespace tribus::test::typography_test {
namespace {

std::string plain(const std::string& text) {
    Mistakes mistakes("t.toml");
    std::string converted;
    return std::string(with_plain_characters(text, converted, mistakes));
}

TEST(Typography, InsideOfQuotesAndCommentsStaysAsItIs) {
    for (const std::string text : {
             "a = \"my \u201cpad\u201d \u2013 \u00a0\"",
             "a = 'it\u2019s'  # a \u201ccomment\u201d",
             "a = \"\"\"\n\u201clines\u201d\n\"\"\"",
             "a = '''\n\u00ablines\u00bb\n'''",
             "a = \"a \\\" quote \u201d\"",
         }) {
        Mistakes mistakes("t.toml");
        std::string converted;
        EXPECT_EQ(with_plain_characters(text, converted, mistakes), text);
        EXPECT_TRUE(mistakes.empty()) << text;
    }
}

TEST(Typography, QuotesBecomePlainOnes) {
    EXPECT_EQ(plain("a = \u201cx\u201d"), "a = \"x\"");
    EXPECT_EQ(plain("a = [\u201cx\u201d, \u201ey\u201c, \u00abz\u00bb]"),
              "a = [\"x\", \"y\", \"z\"]");
    EXPECT_EQ(plain("a = \u2018x\u2019"), "a = 'x'");
    EXPECT_EQ(plain("a = \u201cit\u2019s\u201d"), "a = \"it\u2019s\"");
    EXPECT_EQ(plain("a = \u201cx\" # \u201cy\u201d"), "a = \"x\" # \u201cy\u201d");
    EXPECT_EQ(plain("a = \u201cC:\\x\u201d"), "a = 'C:\\x'");
    EXPECT_EQ(plain("a = \u201cx\nb = 1"), "a = \"x\nb = 1");
}

TEST(Typography, OtherCharactersBecomePlainOnes) {
    EXPECT_EQ(plain("a\u00a0=\u30001"), "a = 1");
    EXPECT_EQ(plain("a = \u22121"), "a = -1");
    EXPECT_EQ(plain("a \u2013 b"), "a \u2013 b") << "no number follows";
    EXPECT_EQ(plain("\u200ba = 1\u2028b = 2"), "a = 1\nb = 2");
}

}  // namespace
}  // namespace tribus::test::typography_test
