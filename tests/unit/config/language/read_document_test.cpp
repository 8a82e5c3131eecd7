#include "config/language/read_document.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::test::read_document_test {
namespace {

using Texts = std::vector<std::string>;

/// A text as it was read, with its mistakes as "line:column: text".
struct ReadText {
    explicit ReadText(const std::string& text) {
        Mistakes mistakes("t.toml");
        document = read_document(text, mistakes);
        for (const Mistake& mistake : mistakes.sorted()) {
            told.push_back(format_mistake(mistake).substr(std::string("t.toml:").size()));
        }
        for (const Entry& entry : document.root.entries) {
            keys.push_back(entry.key);
        }
    }
    Document document;
    Texts told;
    Texts keys;
};

TEST(ReadDocument, HasWhatIsRightInItsOrder) {
    const ReadText read("b = 1\n[a]\nc = 2\n");
    EXPECT_EQ(read.keys, (Texts{"b", "a"}));
    EXPECT_EQ(read.told, Texts{});
    EXPECT_TRUE(read.document.readable);
    EXPECT_FALSE(read.document.lost.mentions("c"));
    EXPECT_FALSE(read.document.lost.affects({2, 1}));
}

TEST(ReadDocument, RepairsALineWhoseIntentionIsClear) {
    const ReadText read("a = 1\nb = ibus\nc = 02\n");
    EXPECT_EQ(read.keys, (Texts{"a", "b", "c"}));
    EXPECT_EQ(read.told,
              (Texts{"2:6: ibus is not a valid value; put text and durations in quotes: b = "
                     "\"ibus\"",
                     "3:5: 02 is not a valid value: a number does not begin with 0; write 2"}));
    EXPECT_TRUE(read.document.readable);
    EXPECT_FALSE(read.document.lost.mentions("b"));
}

TEST(ReadDocument, LeavesOutALineThatMeansNothing) {
    const ReadText read("[a]\nx = 1\n[b]\nfirst (second)\ny = 2\n");
    EXPECT_EQ(read.keys, (Texts{"a", "b"}));
    ASSERT_EQ(read.told.size(), 1U);
    EXPECT_EQ(read.told[0].substr(0, 24), "4:7: not valid TOML: Err");
    for (const std::string word : {"first", "second"}) {
        EXPECT_TRUE(read.document.lost.mentions(word)) << word;
    }
    EXPECT_FALSE(read.document.lost.mentions("y"));
    EXPECT_TRUE(read.document.lost.affects({3, 1}));
    EXPECT_FALSE(read.document.lost.affects({1, 1}));
    EXPECT_FALSE(read.document.lost.affects({4, 1}));
}

TEST(ReadDocument, LosesTextOfTheFirstLineWithoutAHeader) {
    const ReadText read("first (second)\ny = 2\n");
    EXPECT_EQ(read.keys, Texts{"y"});
    EXPECT_TRUE(read.document.lost.affects({1, 1}));
    const ReadText second("y = 2\nfirst (second)\nz = 2\n");
    EXPECT_EQ(second.keys, (Texts{"y", "z"}));
    EXPECT_TRUE(second.document.lost.affects({1, 1}));
}

TEST(ReadDocument, HasNoTableForAHeaderThatCouldNotBeRead) {
    const ReadText read("[a]\nx = 1\n[b c]\ny = 2\n[d]\nz = 3\n");
    EXPECT_EQ(read.keys, (Texts{"a", "d"}));
    ASSERT_EQ(read.told.size(), 1U);
    EXPECT_EQ(read.told[0].substr(0, 2), "3:");
    EXPECT_TRUE(read.document.lost.mentions("b"));
    EXPECT_TRUE(read.document.lost.affects({3, 1}));
}

TEST(ReadDocument, NamesTheBeginOfWhatIsGivenTwice) {
    const ReadText read("[a]\nx = 1\n \tx = 2\n  [a]\n");
    EXPECT_EQ(read.told,
              (Texts{"3:3: this key or table was already given further up; give each once",
                     "4:3: this key or table was already given further up; give each once"}));
}

TEST(ReadDocument, NamesTheEndOfAnEarlierLineThatIsNotClosed) {
    const ReadText read("[a]\n\n  x = [1, 2 \t\n\ny = 3\n");
    EXPECT_EQ(read.told, Texts{"3:12: this line ends too early; a closing ] is missing"});
    ASSERT_EQ(read.keys, Texts{"a"});
    EXPECT_EQ(read.document.root.entries[0].value.as<Table>()->entries.size(), 2U);
}

TEST(ReadDocument, NamesTheBeginOfAStatementThatDoesNotEnd) {
    const ReadText read("[a]\nv = 0\n  x = \"\"\"\ny = 1\nz = 2\n");
    EXPECT_EQ(read.told,
              Texts{"3:3: the statement that begins here does not end; a closing quote, ] or } is "
                    "missing"});
    ASSERT_EQ(read.keys, Texts{"a"});
    EXPECT_EQ(read.document.root.entries[0].value.as<Table>()->entries.size(), 3U);
    EXPECT_TRUE(read.document.lost.mentions("x"));
    EXPECT_FALSE(read.document.lost.mentions("y"));
    EXPECT_TRUE(read.document.lost.affects({1, 1}));
}

TEST(ReadDocument, FindsAtMost32MistakesOfSyntax) {
    std::string text;
    for (int i = 0; i < 32; ++i) {
        text += "= \n";
    }
    const ReadText all(text + "a = 1\n");
    EXPECT_EQ(all.told.size(), 32U);
    EXPECT_EQ(all.keys, Texts{"a"});
    EXPECT_TRUE(all.document.readable);
    const ReadText more(text + "= \na = 1\n");
    EXPECT_EQ(more.told.size(), 32U);
    EXPECT_EQ(more.keys, Texts{});
    EXPECT_FALSE(more.document.readable);
}

/// Each attempt at the first mistake ends at the second one, so it takes no time.
TEST(ReadDocument, EndsItsAttemptsInALongText) {
    const std::string wrong = "x = 1\n= 1\n= 2\ny = 3\n";
    const ReadText brief(wrong + "# " + std::string(1000, 'x') + "\n");
    EXPECT_EQ(brief.told.size(), 2U);
    EXPECT_TRUE(brief.document.readable);
    const ReadText long_one(wrong + "# " + std::string(450'000, 'x') + "\n");
    EXPECT_EQ(long_one.told.size(), 1U);
    EXPECT_FALSE(long_one.document.readable);
    EXPECT_EQ(long_one.keys, Texts{});
}

TEST(ReadDocument, TellsOfADepthThatNoDetourLeadsAround) {
    const std::string deep(60, '[');
    const ReadText read("a = 1\nb = " + deep);
    ASSERT_FALSE(read.told.empty());
    EXPECT_EQ(read.told[0].substr(read.told[0].find(": ") + 2),
              "more than 32 nested lists and tables; a configuration needs only a few");
}

TEST(ReadDocument, HasAtMostFourMebibytes) {
    std::string text = "a = 1\n";
    while (text.size() < kMostConfigurationBytes) {
        text += "#" + std::string(1022, 'x') + "\n";
    }
    text.resize(kMostConfigurationBytes);
    EXPECT_EQ(ReadText(text).keys, Texts{"a"});
    const ReadText longer(text + "x");
    EXPECT_EQ(longer.told, Texts{"1:1: the file is too long; allowed: at most 4194304 bytes"});
    EXPECT_EQ(longer.keys, Texts{});
    EXPECT_FALSE(longer.document.readable);
}

TEST(LostText, MentionsItsWholeWords) {
    LostText lost;
    lost.add_line("a.b-c_9 = \"d e\", \u00c0f]", 3);
    lost.add_line("  g", 7);
    for (const std::string word : {"a", "b-c_9", "d", "e", "\u00c0f", "g"}) {
        EXPECT_TRUE(lost.mentions(word)) << word;
    }
    for (const std::string word : {"b", "c_9", "d e", "f", "h", "\u00c0"}) {
        EXPECT_FALSE(lost.mentions(word)) << word;
    }
}

TEST(LostText, AffectsTheTablesOfItsLines) {
    LostText lost;
    lost.add_line("", 3);
    lost.add_line("a", 7);
    EXPECT_TRUE(lost.affects({3, 9}));
    EXPECT_TRUE(lost.affects({7, 1}));
    EXPECT_FALSE(lost.affects({4, 1}));
    EXPECT_FALSE(lost.mentions("b"));
}

}  // namespace
}  // namespace tribus::test::read_document_test
