#include "config/language/typography.h"

#include <string>
#include <vector>

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

/// The mistakes as "line:column: text".
std::vector<std::string> told(const std::string& text) {
    Mistakes mistakes("f");
    std::string converted;
    with_plain_characters(text, converted, mistakes);
    std::vector<std::string> lines;
    for (const Mistake& mistake : mistakes.sorted()) {
        lines.push_back(format_mistake(mistake).substr(2));
    }
    return lines;
}

TEST(Typography, IsPlainForEveryCharacterThatLooksLikeAnother) {
    for (const std::string blank :
         {"\v", "\f", "\u00a0", "\u2000", "\u2005", "\u200a", "\u202f", "\u205f", "\u3000"}) {
        EXPECT_EQ(plain("a" + blank + "= 1"), "a = 1") << blank;
    }
    for (const std::string none :
         {"\u00ad", "\u200b", "\u200f", "\u202a", "\u202e", "\u2060", "\ufeff"}) {
        EXPECT_EQ(plain("a" + none + "= 1"), "a= 1") << none;
    }
    for (const std::string dash : {"\u2010", "\u2013", "\u2015", "\u2212"}) {
        EXPECT_EQ(plain("a = " + dash + "1"), "a = -1") << dash;
    }
    for (const std::string end : {"\u0085", "\u2028", "\u2029"}) {
        EXPECT_EQ(plain("a = 1" + end + "b = 2"), "a = 1\nb = 2");
    }
    for (const std::string quote : {"\u00ab", "\u00bb", "\u201c", "\u201f", "\u2033", "\uff02"}) {
        EXPECT_EQ(plain("a = " + quote + "x" + quote), "a = \"x\"") << quote;
    }
    for (const std::string quote :
         {"`", "\u00b4", "\u2018", "\u201b", "\u2032", "\u2039", "\u203a", "\uff07"}) {
        EXPECT_EQ(plain("a = " + quote + "x" + quote), "a = 'x'") << quote;
    }
}

TEST(Typography, LeavesAllOtherCharacters) {
    for (const std::string other :
         {"\u00e4", "\u2016", "\u2027", "\u2030", "\u2061", "\ufefe", "\u2213", "\u20ac"}) {
        EXPECT_EQ(plain("a" + other + "= 1"), "a" + other + "= 1");
    }
}

TEST(Typography, ADashBeforeANumberIsAMinus) {
    for (const std::string number : {"0", "5", "9", ".5"}) {
        EXPECT_EQ(plain("a = \u2013" + number), "a = -" + number);
    }
    for (const std::string other : {"/", ":", "a", " 1", "-1", ""}) {
        EXPECT_EQ(plain("a = \u2013" + other), "a = \u2013" + other);
    }
}

TEST(Typography, IsNoneInAsciiAlone) {
    Mistakes mistakes("t.toml");
    std::string converted;
    const std::string text = "a = \"x\"\r\n\t# \x7f";
    EXPECT_EQ(with_plain_characters(text, converted, mistakes).data(), text.data());
    EXPECT_EQ(converted, "");
}

TEST(Typography, MayEndATextThatBeganWithAPlainQuote) {
    EXPECT_EQ(plain("a = \"x\u201d\nb = 1"), "a = \"x\"\nb = 1");
    EXPECT_EQ(plain("a = 'x\u2019 # \u00a0"), "a = 'x' # \u00a0");
    EXPECT_EQ(plain("a = \"x\u2019\n"), "a = \"x\u2019\n") << "of the other kind";
    EXPECT_EQ(plain("a = \"x\\\" y\u201d\n"), "a = \"x\\\" y\u201d\n") << "behind another quote";
    EXPECT_EQ(plain("a = \"\"\"x\u201d\n"), "a = \"\"\"x\u201d\n") << "of several lines";
}

TEST(Typography, IsLookedAtAgainBehindATextThatDoesNotEnd) {
    EXPECT_EQ(plain("a = \"x\nb = \u201cy\u201d"), "a = \"x\nb = \"y\"");
    EXPECT_EQ(plain("a = 'x\nb =\u00a01"), "a = 'x\nb = 1");
    EXPECT_EQ(plain("a = \"x\\\nb =\u00a01"), "a = \"x\\\nb = 1");
    EXPECT_EQ(plain("a = '''x\nb =\u00a01"), "a = '''x\nb =\u00a01");
}

TEST(Typography, IsLookedAtAgainBehindTheEndOfAText) {
    EXPECT_EQ(plain("a = ['C:\\', \u201cx\u201d]"), "a = ['C:\\', \"x\"]");
    EXPECT_EQ(plain("a = [\"\\\\\", \u201cx\u201d]"), "a = [\"\\\\\", \"x\"]");
    EXPECT_EQ(plain("a = \"\"\u00a0"), "a = \"\" ");
    EXPECT_EQ(plain("a = '''x'''\u00a0"), "a = '''x''' ");
    EXPECT_EQ(plain("a = \"\"\"\\\"\"\"\u00a0\"\"\"\u00a0"), "a = \"\"\"\\\"\"\"\u00a0\"\"\" ");
    EXPECT_EQ(plain("# \u00a0\na\u00a0"), "# \u00a0\na ");
    EXPECT_EQ(plain("a = \u201cx\u00a0\"\u00a0b"), "a = \"x\u00a0\" b");
}

TEST(Typography, BetweenQuotesABackslashStandsForItself) {
    EXPECT_EQ(plain("a = \u201c\\\u201d"), "a = '\\'");
    EXPECT_EQ(plain("a = \u201cx\u201d # \\"), "a = \"x\" # \\");
    EXPECT_EQ(plain("a = \u201cx\\y\""), "a = 'x\\y'");
}

TEST(Typography, IsToldOnceForEachKindWithItsLines) {
    EXPECT_EQ(told("\u00e4\u00a0= \u201cx\u201d\n\u2003b\u200b=\u00a0\u201ey\u201c\n"),
              (std::vector<std::string>{
                  "1:2: U+00A0 looks like a space, but is none (also in line 2); allowed: a space",
                  "1:5: \u201c (U+201C) is a typographic quote (also in line 2); allowed: \" or '",
                  "2:3: U+200B is a character without a width; allowed: nothing; delete it"}));
}

TEST(Typography, IsCountedInCharactersAndLines) {
    const std::string blank = " looks like a space, but is none; allowed: a space";
    EXPECT_EQ(told("a = \u201cx\"\u00a0").back(), "1:8: U+00A0" + blank);
    EXPECT_EQ(told("a = \"x\u201d\u00a0").back(), "1:8: U+00A0" + blank);
    EXPECT_EQ(told("a = \"\u00e4\"\u00a0").back(), "1:8: U+00A0" + blank);
    EXPECT_EQ(told("# \u00e4\n\u2028a\u00a0").back(), "3:2: U+00A0" + blank);
    EXPECT_EQ(told("a = \u22121\u00a0").back(), "1:7: U+00A0" + blank);
}

}  // namespace
}  // namespace tribus::test::typography_test
