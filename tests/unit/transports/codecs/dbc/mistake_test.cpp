#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "transports/codecs/dbc/file.h"

/// Mistakes in a DBC text, and the message for the person who must correct it. Whether the file is
/// refused or only a part of it, broken_parts_test.cpp tells.
namespace tribus::mistake_test {
namespace {

/// Returns "line:column: text", or "" if there is no mistake.
std::string mistake_in(std::string_view text) {
    const auto file = parse_dbc(text);
    if (file && file->warnings.empty()) {
        return "";
    }
    const DbcMistake& first = file ? file->warnings.front() : file.error();
    return std::to_string(first.line) + ":" + std::to_string(first.column) + ": " + first.text;
}

/// Returns the mistake in the first signal of a message of eight bytes. The line is 2, S is in
/// column 6.
std::string mistake_in_signal(std::string_view line) {
    return mistake_in("BO_ 1 M: 8 A\n SG_ " + std::string(line) + "\n");
}

/// Returns the mistake in lines after a message with a signal S, which takes lines 1 and 2.
std::string mistake_behind(std::string_view lines) {
    return mistake_in("BO_ 1 M: 8 A\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" B\n" + std::string(lines));
}

TEST(DbcMistake, TextTooLong) {
    EXPECT_EQ(mistake_in(std::string(kLongestDbcText + 1, '\n')),
              "1:1: the text has 16777217 bytes; a DBC file has at most 16777216");
}

TEST(DbcMistake, Utf16) {
    EXPECT_EQ(mistake_in("\xFF\xFE\x42"),
              "1:1: the text is UTF-16; save it as UTF-8 or as Windows-1252");
}

TEST(DbcMistake, NotADbc) {
    EXPECT_EQ(mistake_in("{\"channels\": 3}"),
              "1:1: expected a section such as BO_ or VAL_, found '{'");
}

TEST(DbcMistake, SignalBeyondItsMessage) {
    EXPECT_EQ(mistake_in_signal("S : 57|8@1+ (1,0) [0|0] \"\" B"),
              "2:6: signal S needs 9 bytes, but message M has 8");
    // Motorola: down from bit 62, so bits 62 to 56, then bit 71.
    EXPECT_EQ(mistake_in_signal("S : 62|8@0+ (1,0) [0|0] \"\" B"),
              "2:6: signal S needs 9 bytes, but message M has 8");
    EXPECT_EQ(mistake_in_signal("S : 63|8@0+ (1,0) [0|0] \"\" B"), "");
    EXPECT_EQ(mistake_in_signal("S : 56|8@1+ (1,0) [0|0] \"\" B"), "");
}

TEST(DbcMistake, SignalOfImpossibleLength) {
    EXPECT_EQ(mistake_in_signal("S : 0|0@1+ (1,0) [0|0] \"\" B"),
              "2:12: signal S is 0 bits long; allowed are 1 to 64");
    EXPECT_EQ(mistake_in("BO_ 1 M: 64 A\n SG_ S : 0|65@1+ (1,0) [0|0] \"\" B"),
              "2:12: signal S is 65 bits long; allowed are 1 to 64");
}

TEST(DbcMistake, FactorOf0) {
    EXPECT_EQ(mistake_in_signal("S : 0|8@1+ (0,5) [0|0] \"\" B"),
              "2:18: the factor of signal S is 0: all raw values would have one meaning");
    EXPECT_NE(mistake_in_signal("S : 0|8@1+ (-0.0,5) [0|0] \"\" B"), "");
}

TEST(DbcMistake, NumbersThatAreNone) {
    EXPECT_EQ(mistake_in_signal("S : x|8@1+ (1,0) [0|0] \"\" B"),
              "2:10: expected the start bit, a whole number from 0 to 14279, found 'x'");
    EXPECT_EQ(mistake_in_signal("S : 0|8@1+ (1.2.3,0) [0|0] \"\" B"),
              "2:18: expected the factor, a number such as 0.5 or 1E-3, found '1.2.3'");
    // A decimal comma.
    EXPECT_EQ(mistake_in_signal("S : 0|8@1+ (0,5,0) [0|0] \"\" B"),
              "2:21: expected ')' after the offset, found ','");
    EXPECT_EQ(mistake_in_signal("S : 0|8@1+ (1E999,0) [0|0] \"\" B"),
              "2:18: expected the factor, a number such as 0.5 or 1E-3, found '1E999'");
    EXPECT_EQ(mistake_in("BO_ 0x300 M: 8 A\n"),
              "1:5: expected the id of the message, a whole number from 0 to 4294967295, found "
              "'0x300'");
    EXPECT_EQ(mistake_in("BO_ 5000000000 M: 8 A\n"),
              "1:5: expected the id of the message, a whole number from 0 to 4294967295, found "
              "'5000000000'");
    EXPECT_EQ(mistake_behind("VAL_ 1 S 0.5 \"half\" ;"),
              "3:10: expected a raw value or ';', a whole number of 64 bits, found '0.5'");
}

TEST(DbcMistake, ByteOrderAndSignThatAreNone) {
    EXPECT_EQ(mistake_in_signal("S : 0|8@2+ (1,0) [0|0] \"\" B"),
              "2:14: expected the byte order (0 Motorola, 1 Intel), a whole number from 0 to 1, "
              "found '2'");
    EXPECT_EQ(mistake_in_signal("S : 0|8@1 (1,0) [0|0] \"\" B"),
              "2:16: expected '+' (unsigned) or '-' (signed) after the byte order, found '('");
}

TEST(DbcMistake, MissingUnit) {
    EXPECT_EQ(mistake_in_signal("S : 0|8@1+ (1,0) [0|0] B"),
              "2:29: expected the unit in quotes, found 'B'");
}

TEST(DbcMistake, TextWithoutEndIsShownWhereItBegins) {
    EXPECT_EQ(mistake_in("BO_ 1 M: 8 A\n SG_ S : 0|8@1+ (1,0) [0|0] \"us B\nBO_ 2 N: 8 A\n"),
              "2:29: text without its closing quote");
    EXPECT_EQ(mistake_behind("CM_ \"never closed;\n"), "3:5: text without its closing quote");
}

TEST(DbcMistake, LengthThatNoFrameHas) {
    EXPECT_EQ(mistake_in("BO_ 1 M: 9 A\n"),
              "1:10: message M has 9 bytes; a CAN frame has 0 to 8, with FD also 12, 16, 20, 24, "
              "32, 48 or 64");
    EXPECT_NE(mistake_in("BO_ 1 M: 65 A\n"), "");
    for (const char* const length : {"0", "8", "12", "16", "20", "24", "32", "48", "64"}) {
        EXPECT_EQ(mistake_in("BO_ 1 M: " + std::string(length) + " A\n"), "") << length;
    }
}

TEST(DbcMistake, IdBeyondItsBits) {
    EXPECT_EQ(mistake_in("BO_ 2048 M: 8 A\n"),
              "1:5: the id of message M, 2048, has more than 11 bits; a 29-bit id has bit 31 set "
              "in the file, so add 2147483648 to it");
    EXPECT_EQ(mistake_in("BO_ 2684354560 M: 8 A\n"),  // 0xA0000000
              "1:5: the id of message M, 2684354560, has more than 29 bits besides bit 31");
    EXPECT_EQ(mistake_in("BO_ 2047 M: 8 A\nBO_ 2684354559 N: 8 A\n"), "");
}

TEST(DbcMistake, TwoMessagesWithOneId) {
    EXPECT_EQ(mistake_in("BO_ 1 M: 8 A\n\nBO_ 1 N: 8 A\n"),
              "3:7: message N has the id of message M in line 1");
}

TEST(DbcMistake, TwoMessagesWithOneName) {
    EXPECT_EQ(mistake_in("BO_ 1 M: 8 A\nBO_ 2 M: 8 A\n"),
              "2:7: there is another message M in line 1");
}

TEST(DbcMistake, TwoMessagesWithOneLongName) {
    EXPECT_EQ(mistake_in("BO_ 1 M: 8 A\nBO_ 2 N: 8 A\n"
                         "BA_ \"SystemMessageLongSymbol\" BO_ 2 \"M\";\n"),
              "2:7: there is another message M in line 1");
}

TEST(DbcMistake, TwoSignalsWithOneName) {
    EXPECT_EQ(mistake_in_signal("S : 0|8@1+ (1,0) [0|0] \"\" B\n"
                                " SG_ S : 8|8@1+ (1,0) [0|0] \"\" B"),
              "3:6: message M has another signal S in line 2");
}

TEST(DbcMistake, TwoSignalsWithOneLongName) {
    EXPECT_EQ(mistake_in("BO_ 1 M: 8 A\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" B\n"
                         " SG_ T : 8|8@1+ (1,0) [0|0] \"\" B\n"
                         "BA_ \"SystemSignalLongSymbol\" SG_ 1 T \"S\";\n"),
              "3:6: message M has another signal S in line 2");
}

TEST(DbcMistake, FloatOfTheWrongLength) {
    EXPECT_EQ(mistake_behind("SIG_VALTYPE_ 1 S : 1;"),
              "3:14: signal S is declared as a floating-point number of 32 bits, but is 8 bits "
              "long");
    EXPECT_EQ(mistake_in("BO_ 1 M: 8 A\n SG_ S : 0|32@1+ (1,0) [0|0] \"\" B\n"
                         "SIG_VALTYPE_ 1 S : 2;"),
              "3:14: signal S is declared as a floating-point number of 64 bits, but is 32 bits "
              "long");
}

TEST(DbcMistake, UnknownKindOfValue) {
    EXPECT_EQ(mistake_behind("SIG_VALTYPE_ 1 S : 3;"),
              "3:20: expected the kind of value (0 integer, 1 float, 2 double), a whole number "
              "from 0 to 2, found '3'");
}

TEST(DbcMistake, SelectorThatDoesNotExist) {
    EXPECT_EQ(mistake_behind("SG_MUL_VAL_ 1 S Page 1-1;"),
              "3:17: signal S depends on Page, which is not a signal of its message");
}

TEST(DbcMistake, SelectorRangeBackwards) {
    EXPECT_EQ(mistake_behind("SG_MUL_VAL_ 1 S S 2-1;"), "3:19: the range ends before it begins");
}

TEST(DbcMistake, SelectorsInACircle) {
    EXPECT_EQ(mistake_behind("SG_MUL_VAL_ 1 S S 1-1;"),
              "2:6: signal S depends on more than 8 selectors, or on itself");
}

TEST(DbcMistake, SelectorThatIsAFloat) {
    EXPECT_EQ(mistake_in("BO_ 1 M: 8 A\n SG_ Page M : 0|32@1+ (1,0) [0|0] \"\" B\n"
                         "SIG_VALTYPE_ 1 Page : 1;"),
              "2:6: signal Page selects others, so it must be an integer");
}

TEST(DbcMistake, MultiplexingMarkThatIsNone) {
    EXPECT_EQ(mistake_in_signal("S m1x : 0|8@1+ (1,0) [0|0] \"\" B"),
              "2:8: expected ':' or a multiplexing mark (M, m0 or m0M), found 'm1x'");
    EXPECT_NE(mistake_in_signal("S mM : 0|8@1+ (1,0) [0|0] \"\" B"), "");
}

TEST(DbcMistake, AttributesThatAreNoNumber) {
    EXPECT_EQ(mistake_behind("BA_ \"GenMsgCycleTime\" BO_ 1 \"fast\";"),
              "3:29: GenMsgCycleTime of message M is 'fast'; it is a number of milliseconds, at "
              "most 1000000000");
    EXPECT_EQ(mistake_behind("BA_ \"RcE2eDataId\" BO_ 1 -1;"),
              "3:25: RcE2eDataId of message M is '-1'; it is a whole number from 0 to 4294967295");
}

TEST(DbcMistake, StatementThatWasCutOff) {
    EXPECT_EQ(mistake_behind("VAL_ 1 S 1 \"on\" 2"),
              "3:18: expected the meaning of the value in quotes, found the end of the file");
    EXPECT_EQ(mistake_behind("BA_ \"GenMsgCycleTime\" BO_ 1"),
              "3:28: expected the value of the attribute, a number or a text in quotes, found the "
              "end of the file");
}

TEST(DbcMistake, StatementWithoutItsEndBeforeAnother) {
    EXPECT_EQ(mistake_behind("BA_ \"GenMsgCycleTime\" BO_ 1 10\nVAL_ 1 S 1 \"on\" ;"),
              "4:1: expected ';' at the end of the statement, found 'VAL_'");
}

}  // namespace
}  // namespace tribus::mistake_test
