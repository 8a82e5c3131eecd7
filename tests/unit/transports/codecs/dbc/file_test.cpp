#include "transports/codecs/dbc/file.h"

#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::file_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

DbcFile parsed(std::string_view text) {
    auto file = parse_dbc(text);
    EXPECT_TRUE(file) << file.error().line << ":" << file.error().column << ": "
                      << file.error().text;
    return file ? std::move(*file) : DbcFile{};
}

/// Returns the first signal of a message of eight bytes with this SG_ line.
DbcSignal signal_of(std::string_view line) {
    const DbcFile file = parsed("BO_ 1 M: 8 A\n SG_ " + std::string(line) + "\n");
    return file.messages.empty() || file.messages[0].signals.empty() ? DbcSignal{}
                                                                     : file.messages[0].signals[0];
}

/// Returns a message of eight bytes with a signal S and more lines.
DbcMessage message_with(std::string_view lines) {
    const DbcFile file =
        parsed("BO_ 1 M: 8 A\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" B\n" + std::string(lines) + "\n");
    return file.messages.empty() ? DbcMessage{} : file.messages[0];
}

TEST(DbcFile, ReadsAMessage) {
    const DbcFile file = parsed("BO_ 768 RcA: 7 RcGateway\n");
    ASSERT_EQ(file.messages.size(), 1U);
    const DbcMessage& message = file.messages[0];
    EXPECT_EQ(message.name, "RcA");
    EXPECT_EQ(message.id, 0x300U);
    EXPECT_FALSE(message.extended);
    EXPECT_FALSE(message.fd);
    EXPECT_EQ(message.length, 7U);
    EXPECT_EQ(message.sender, "RcGateway");
    EXPECT_EQ(message.line, 1U);
    EXPECT_EQ(message.cycle_time, std::nullopt);
    EXPECT_EQ(message.e2e_data_id, std::nullopt);
}

// docs/protocols/can.md, "DBC files": bit 31 set = 29-bit id. 2566844926 = 0x98FEF1FE.
TEST(DbcFile, TakesBit31OfTheIdForA29BitId) {
    const DbcFile file = parsed("BO_ 2566844926 M: 8 A\n");
    EXPECT_EQ(file.messages.at(0).id, 0x18FEF1FEU);
    EXPECT_TRUE(file.messages.at(0).extended);
}

TEST(DbcFile, ReadsASignal) {
    const DbcSignal signal = signal_of("Ch01 : 16|12@1+ (0.5,476) [476|2523] \"us\" Consumer");
    EXPECT_EQ(signal.name, "Ch01");
    EXPECT_EQ(signal.start_bit, 16U);
    EXPECT_EQ(signal.bit_length, 12U);
    EXPECT_EQ(signal.byte_order, DbcByteOrder::intel);
    EXPECT_FALSE(signal.is_signed);
    EXPECT_EQ(signal.kind, DbcValueKind::integer);
    EXPECT_EQ(signal.factor, 0.5);
    EXPECT_EQ(signal.offset, 476);
    EXPECT_TRUE(signal.has_range());
    EXPECT_EQ(signal.minimum, 476);
    EXPECT_EQ(signal.maximum, 2523);
    EXPECT_EQ(signal.unit, "us");
    EXPECT_EQ(signal.selector, std::nullopt);
    EXPECT_EQ(signal.line, 2U);
}

TEST(DbcFile, ReadsMotorolaOrderAndSign) {
    const DbcSignal signal = signal_of("S : 39|16@0- (-1E-3,+4) [0|0] \"\" B");
    EXPECT_EQ(signal.byte_order, DbcByteOrder::motorola);
    EXPECT_TRUE(signal.is_signed);
    EXPECT_EQ(signal.factor, -0.001);
    EXPECT_EQ(signal.offset, 4);
}

TEST(DbcFile, TakesTwoZerosForNoRange) {
    EXPECT_FALSE(signal_of("S : 0|8@1+ (1,0) [0|0] \"\" B").has_range());
}

// Tools on .NET print these limits of a double: 2.4E+293 beyond it.
TEST(DbcFile, BringsLimitsBeyondADoubleIntoOne) {
    const DbcSignal signal =
        signal_of("S : 0|64@1- (1,0) [-1.79769313486232E+308|1.79769313486232E+308] \"\" B");
    EXPECT_EQ(signal.maximum, std::numeric_limits<double>::max());
    EXPECT_EQ(signal.minimum, -std::numeric_limits<double>::max());
}

TEST(DbcFile, DoesWithoutBlanksWhereTheyTellNothing) {
    const DbcSignal signal = signal_of("S:7|8@0-(2,3)[4|5]\"u\"B");
    EXPECT_EQ(signal.byte_order, DbcByteOrder::motorola);
    EXPECT_EQ(signal.factor, 2);
    EXPECT_EQ(signal.maximum, 5);
    EXPECT_EQ(signal.unit, "u");
}

TEST(DbcFile, AcceptsByteOrderMarkTabsAndCarriageReturns) {
    const DbcFile file = parsed(
        "\xEF\xBB\xBFVERSION \"\"\r\n\r\nBO_\t1\tM :\t8\tA\r\n"
        "\tSG_\tS\t:\t0|8@1+\t(1,0)\t[0|0]\t\"\"\tB\r\n");
    ASSERT_EQ(file.messages.size(), 1U);
    EXPECT_EQ(file.messages[0].line, 3U);
    EXPECT_EQ(file.messages[0].signals.at(0).line, 4U);
}

TEST(DbcFile, AcceptsReceiversInAnyManner) {
    const DbcFile file = parsed(
        "BO_ 1 M: 8 Vector__XXX\n"
        " SG_ S1 : 0|8@1+ (1,0) [0|0] \"\"  A,B\n"
        " SG_ S2 : 8|8@1+ (1,0) [0|0] \"\" Vector__XXX\n"
        " SG_ S3 : 16|8@1+ (1,0) [0|0] \"\" A , B,\n  C\n"
        " SG_ S4 : 24|8@1+ (1,0) [0|0] \"\"\n");
    EXPECT_EQ(file.messages.at(0).signals.size(), 4U);
}

TEST(DbcFile, TurnsCp1252TextIntoUtf8) {
    EXPECT_EQ(signal_of("S : 0|8@1+ (1,0) [0|0] \"\xB0\x43\" B").unit, "\xC2\xB0\x43");  // degree
    EXPECT_EQ(signal_of("S : 0|8@1+ (1,0) [0|0] \"\x80\" B").unit, "\xE2\x82\xAC");      // euro
}

TEST(DbcFile, LeavesUtf8Alone) {
    EXPECT_EQ(signal_of("S : 0|8@1+ (1,0) [0|0] \"\xC2\xB0\x43\" B").unit, "\xC2\xB0\x43");
}

TEST(DbcFile, KnowsEscapedQuotes) {
    const DbcMessage message = message_with(R"(VAL_ 1 S 1 "say \"on\"" 2 "C:\\" 3 "a;b" ;)");
    const std::vector<DbcValueText> expected{{1, "say \"on\""}, {2, "C:\\"}, {3, "a;b"}};
    EXPECT_EQ(message.signals.at(0).value_texts, expected);
}

TEST(DbcFile, ReadsValueTextsWithSignsAndUpTo64Bits) {
    const DbcMessage message =
        message_with(R"(VAL_ 1 S -5 "low" +6 "six" 7.0 "seven" 18446744073709551615 "all" ;)");
    const std::vector<DbcValueText> expected{{-5, "low"}, {6, "six"}, {7, "seven"}, {-1, "all"}};
    EXPECT_EQ(message.signals.at(0).value_texts, expected);
}

TEST(DbcFile, SkipsSectionsThatSayNothingOfFrames) {
    const DbcMessage message = message_with(R"(
CM_ "a comment; with
BO_ 5 many lines";
CM_ SG_ 1 S "text";
BO_TX_BU_ 1 : A,B;
VAL_TABLE_ Table 0 "a" 1 "b" ;
VAL_ EnvironmentVariable 0 "a" ;
EV_ E: 0 [0|1] "" 0 1 DUMMY_NODE_VECTOR0 B;
SIG_GROUP_ 1 Group 1 : S;
BA_DEF_REL_ BU_SG_REL_ "GenSigTimeout" INT 0 1;
BA_DEF_ SG_ "Other" FLOAT -1.5 2;
BA_ "Other" SG_ 1 S -3.5E-1;
BA_ "GenMsgCycleTime" 77;
SOMETHING_NEW_ 1 2 "three" (4) ? ;)");
    EXPECT_EQ(message.signals.size(), 1U);
    EXPECT_EQ(message.cycle_time, std::nullopt);
}

TEST(DbcFile, SkipsTheListOfSectionNamesInEitherForm) {
    EXPECT_EQ(parsed("NS_ :\n\tCM_\n\tBA_DEF_\n\tBO_TX_BU_\n\tSG_MUL_VAL_\n\nBS_:\n\nBU_: A B\n"
                     "BO_ 1 M: 8 A\n")
                  .messages.size(),
              1U);
    EXPECT_EQ(parsed("NS_ : CM_ BA_DEF_ VAL_\nBS_: 500000 : 1,2\nBU_:\n A\n B\nBO_ 1 M: 8 A\n")
                  .messages.size(),
              1U);
    EXPECT_EQ(parsed("NS_:\nBO_ 1 M: 8 A\n").messages.size(), 1U);
}

TEST(DbcFile, IgnoresLineComments) {
    EXPECT_EQ(parsed("// BO_ 1 M: nonsense\nBO_ 2 M: 8 A // sender\n").messages.at(0).id, 2U);
}

// Old editors end a file with 0x1A.
TEST(DbcFile, IgnoresAnEndMarkAtTheEnd) {
    EXPECT_EQ(parsed("BO_ 2 M: 8 A\r\n\x1A").messages.size(), 1U);
}

TEST(DbcFile, ReadsSectionsInAnyOrder) {
    const DbcFile file = parsed(
        "SIG_VALTYPE_ 1 S : 1;\n"
        "BA_ \"GenMsgCycleTime\" BO_ 1 20;\n"
        "VAL_ 1 S 3 \"three\" ;\n"
        "BA_ \"SystemSignalLongSymbol\" SG_ 1 S \"LongS\";\n"
        "BO_ 1 M: 4 A\n SG_ S : 0|32@1- (1,0) [0|0] \"\" B\n");
    const DbcMessage& message = file.messages.at(0);
    EXPECT_EQ(message.cycle_time, milliseconds(20));
    ASSERT_NE(message.find("LongS"), nullptr);
    EXPECT_EQ(message.find("LongS")->kind, DbcValueKind::float32);
    EXPECT_EQ(message.find("LongS")->value_texts.size(), 1U);
}

TEST(DbcFile, IgnoresWhatReferencesSignalsThatDoNotExist) {
    const DbcMessage message = message_with(
        "SIG_VALTYPE_ 1 Gone : 1;\nSIG_VALTYPE_ 9 S : 1;\nVAL_ 1 Gone 1 \"x\" ;\n"
        "BA_ \"GenMsgCycleTime\" BO_ 9 5;\nSG_MUL_VAL_ 1 Gone S 1-1;");
    EXPECT_EQ(message.signals.at(0).kind, DbcValueKind::integer);
    EXPECT_TRUE(message.signals.at(0).value_texts.empty());
}

// docs/protocols/can.md, "DBC files": this message has the signals without a message, and may be
// anywhere.
TEST(DbcFile, IgnoresTheMessageOfOrphanedSignals) {
    const DbcFile file = parsed(
        "BO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 Vector__XXX\n"
        " SG_ Orphan : 0|8@1+ (1,0) [0|0] \"\" Vector__XXX\n"
        " SG_ Empty : 0|0@1+ (0,0) [0|0] \"\" Vector__XXX\n"
        "BO_ 1 M: 8 A\n");
    ASSERT_EQ(file.messages.size(), 1U);
    EXPECT_EQ(file.messages[0].name, "M");
}

TEST(DbcFile, ReplacesShortNamesByLongOnes) {
    const DbcFile file = parsed(
        "BO_ 1 Short: 8 A\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" B\n"
        "BA_DEF_ BO_ \"SystemMessageLongSymbol\" STRING ;\n"
        "BA_DEF_DEF_ \"SystemMessageLongSymbol\" \"\";\n"
        "BA_ \"SystemMessageLongSymbol\" BO_ 1 \"AMessageWithAVeryVeryLongName\";\n"
        "BA_ \"SystemSignalLongSymbol\" SG_ 1 S \"ASignalWithALongName\";\n"
        "VAL_ 1 S 1 \"on\" ;\n");
    const DbcMessage* const message = file.find("AMessageWithAVeryVeryLongName");
    ASSERT_NE(message, nullptr);
    ASSERT_NE(message->find("ASignalWithALongName"), nullptr);
    EXPECT_EQ(message->find("ASignalWithALongName")->value_texts.size(), 1U);
    EXPECT_EQ(file.find("Short"), nullptr);
    EXPECT_EQ(message->find("S"), nullptr);
}

TEST(DbcFile, TakesCycleTimeFromTheMessageElseTheDefault) {
    const DbcFile file = parsed(
        "BO_ 1 Own: 8 A\nBO_ 2 Default: 8 A\nBO_ 3 None: 8 A\nBO_ 4 Fraction: 8 A\n"
        "BA_DEF_ BO_ \"GenMsgCycleTime\" FLOAT 0 65535;\n"
        "BA_DEF_DEF_ \"GenMsgCycleTime\" 100;\n"
        "BA_ \"GenMsgCycleTime\" BO_ 1 10;\nBA_ \"GenMsgCycleTime\" BO_ 3 0;\n"
        "BA_ \"GenMsgCycleTime\" BO_ 4 2.5;\n");
    EXPECT_EQ(file.find("Own")->cycle_time, milliseconds(10));
    EXPECT_EQ(file.find("Default")->cycle_time, milliseconds(100));
    EXPECT_EQ(file.find("None")->cycle_time, std::nullopt);
    EXPECT_EQ(file.find("Fraction")->cycle_time, microseconds(2500));
}

TEST(DbcFile, TakesADataIdFromTheMessageAndADefaultOnlyIfItIsNot0) {
    const std::string messages = "BO_ 1 Own: 8 A\nBO_ 2 Other: 8 A\nBO_ 3 Zero: 8 A\n";
    const std::string values = "BA_ \"RcE2eDataId\" BO_ 1 21059;\nBA_ \"RcE2eDataId\" BO_ 3 0;\n";
    const DbcFile none = parsed(messages + values + "BA_DEF_DEF_ \"RcE2eDataId\" 0;\n");
    EXPECT_EQ(none.find("Own")->e2e_data_id, 21059U);
    EXPECT_EQ(none.find("Other")->e2e_data_id, std::nullopt);
    EXPECT_EQ(none.find("Zero")->e2e_data_id, 0U);
    const DbcFile seven = parsed(messages + values + "BA_DEF_DEF_ \"RcE2eDataId\" 7;\n");
    EXPECT_EQ(seven.find("Other")->e2e_data_id, 7U);
}

TEST(DbcFile, TakesALongMessageForFd) {
    const DbcFile file = parsed("BO_ 1 Fd: 12 A\nBO_ 2 Classic: 8 A\n");
    EXPECT_TRUE(file.find("Fd")->fd);
    EXPECT_FALSE(file.find("Classic")->fd);
}

// The enumeration of docs/protocols/can.md, "DBC files". Indices 14 and 15 are FD.
constexpr std::string_view kFrameFormats =
    "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\",\"J1939PG\","
    "\"reserved\",\"reserved\",\"reserved\",\"reserved\",\"reserved\",\"reserved\",\"reserved\","
    "\"reserved\",\"reserved\",\"reserved\",\"StandardCAN_FD\",\"ExtendedCAN_FD\";\n";

DbcMessage with_format(std::string_view definition, std::string_view value) {
    return message_with(std::string(definition) + "BA_ \"VFrameFormat\" BO_ 1 " +
                        std::string(value) + ";");
}

TEST(DbcFile, ReadsTheFrameFormatByIndexAndByText) {
    EXPECT_TRUE(with_format(kFrameFormats, "14").fd);
    EXPECT_TRUE(with_format(kFrameFormats, "15").fd);
    EXPECT_TRUE(with_format(kFrameFormats, "\"ExtendedCAN_FD\"").fd);
    EXPECT_FALSE(with_format(kFrameFormats, "0").fd);
    EXPECT_TRUE(with_format(kFrameFormats, "3").j1939);
    EXPECT_TRUE(with_format(kFrameFormats, "\"J1939PG\"").j1939);
}

TEST(DbcFile, ReadsTheFrameFormatDeclaredAsIntOrNotAtAll) {
    EXPECT_TRUE(with_format("BA_DEF_ BO_ \"VFrameFormat\" INT 0 15;\n", "14").fd);
    EXPECT_TRUE(with_format("", "14").fd);
    EXPECT_TRUE(with_format("", "3").j1939);
}

TEST(DbcFile, ReadsTheFrameFormatOfAShorterListByItsNames) {
    constexpr std::string_view kShort =
        "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"StandardCAN_FD\","
        "\"J1939PG\";\n";
    EXPECT_TRUE(with_format(kShort, "2").fd);
    EXPECT_TRUE(with_format(kShort, "3").j1939);
}

TEST(DbcFile, TakesTheFrameFormatFromTheDefault) {
    EXPECT_TRUE(message_with("BA_DEF_DEF_ \"VFrameFormat\" \"StandardCAN_FD\";").fd);
}

TEST(DbcFile, SwitchesTheBitRateOnlyInFdFrames) {
    const DbcFile file = parsed(
        "BO_ 1 Classic: 8 A\nBO_ 2 Fd: 12 A\nBO_ 3 Slow: 12 A\n"
        "BA_DEF_ BO_ \"CANFD_BRS\" ENUM \"0\",\"1\";\nBA_DEF_DEF_ \"CANFD_BRS\" \"1\";\n"
        "BA_ \"CANFD_BRS\" BO_ 3 0;\n");
    EXPECT_FALSE(file.find("Classic")->bit_rate_switch);
    EXPECT_TRUE(file.find("Fd")->bit_rate_switch);
    EXPECT_FALSE(file.find("Slow")->bit_rate_switch);
    EXPECT_FALSE(parsed("BO_ 2 Fd: 12 A\n").find("Fd")->bit_rate_switch);
}

// DM1 of J1939 uses the transport protocol. Files for whole vehicles have such messages.
TEST(DbcFile, MarksLongJ1939MessagesAsNoSingleFrame) {
    const DbcFile file = parsed(
        "BO_ 2566834942 Dm1: 39 A\n SG_ Last : 304|8@1+ (1,0) [0|0] \"\" B\n"
        "BA_DEF_DEF_ \"VFrameFormat\" \"J1939PG\";\n");
    EXPECT_TRUE(file.messages.at(0).multi_packet);
    EXPECT_FALSE(file.messages.at(0).fd);
}

TEST(DbcFile, MultiplexesByTheOneSelector) {
    const DbcFile file = parsed(
        "BO_ 1 M: 8 A\n SG_ First m7 : 8|8@1+ (1,0) [0|0] \"\" B\n"
        " SG_ Page M : 0|8@1+ (1,0) [0|0] \"\" B\n SG_ Always : 16|8@1+ (1,0) [0|0] \"\" B\n");
    const auto& signals = file.messages.at(0).signals;
    EXPECT_EQ(signals.at(0).selector, 1U);
    EXPECT_EQ(signals.at(0).selected_by, (std::vector<DbcSelectorRange>{{7, 7}}));
    EXPECT_FALSE(signals.at(0).is_selector);
    EXPECT_TRUE(signals.at(1).is_selector);
    EXPECT_EQ(signals.at(1).selector, std::nullopt);
    EXPECT_EQ(signals.at(2).selector, std::nullopt);
}

TEST(DbcFile, MultiplexesByNestedSelectorsAndRanges) {
    const DbcFile file = parsed(
        "BO_ 1 M: 8 A\n SG_ Outer M : 0|8@1+ (1,0) [0|0] \"\" B\n"
        " SG_ Inner m3M : 8|8@1+ (1,0) [0|0] \"\" B\n"
        " SG_ Deep m5 : 16|8@1+ (1,0) [0|0] \"\" B\n"
        "SG_MUL_VAL_ 1 Deep Inner 5-5, 16-20;\nSG_MUL_VAL_ 1 Inner Outer 3-3;\n");
    const auto& signals = file.messages.at(0).signals;
    EXPECT_EQ(signals.at(1).selector, 0U);
    EXPECT_TRUE(signals.at(1).is_selector);
    EXPECT_EQ(signals.at(2).selector, 1U);
    EXPECT_EQ(signals.at(2).selected_by, (std::vector<DbcSelectorRange>{{5, 5}, {16, 20}}));
}

// Files in public collections are like this.
TEST(DbcFile, ReadsALastStatementWithoutItsSemicolon) {
    EXPECT_EQ(message_with("BA_ \"GenMsgCycleTime\" BO_ 1 10").cycle_time, milliseconds(10));
    EXPECT_EQ(message_with("VAL_ 1 S 1 \"on\"").signals.at(0).value_texts,
              (std::vector<DbcValueText>{{1, "on"}}));
    EXPECT_EQ(message_with("SIG_VALTYPE_ 1 S : 0").signals.at(0).kind, DbcValueKind::integer);
    EXPECT_TRUE(message_with("BA_DEF_DEF_ \"VFrameFormat\" \"StandardCAN_FD\"").fd);
    EXPECT_EQ(message_with("CM_ SG_ 1 S \"text\"").signals.size(), 1U);
    const DbcFile file = parsed(
        "BO_ 1 M: 8 A\n SG_ Page M : 0|8@1+ (1,0) [0|0] \"\" B\n"
        " SG_ S m0 : 8|8@1+ (1,0) [0|0] \"\" B\nSG_MUL_VAL_ 1 S Page 2-3");
    EXPECT_EQ(file.messages.at(0).signals.at(1).selected_by,
              (std::vector<DbcSelectorRange>{{2, 3}}));
}

TEST(DbcFile, ReadsATextWithoutAnyMessageAsAnEmptyFile) {
    EXPECT_TRUE(parsed("").messages.empty());
    EXPECT_TRUE(
        parsed("VERSION \"\"\nNS_ :\nBS_:\nBU_: A B\nVAL_TABLE_ T 0 \"a\" ;\n").messages.empty());
}

TEST(DbcFile, ABareMarkForMultiplexedTakesItsPagesFromTheirStatement) {
    const DbcFile file = parsed(
        "BO_ 1 M: 8 A\n SG_ Page M : 0|8@1+ (1,0) [0|0] \"\" B\n"
        " SG_ S m : 8|8@1+ (1,0) [0|0] \"\" B\nSG_MUL_VAL_ 1 S Page 2-3;\n");
    const DbcSignal& signal = file.messages.at(0).signals.at(1);
    EXPECT_FALSE(signal.page_unknown);
    EXPECT_EQ(signal.selector, 0U);
    EXPECT_EQ(signal.selected_by, (std::vector<DbcSelectorRange>{{2, 3}}));
}

/// Returns whether the page of the last signal of a message is unknown.
bool page_unknown(std::string_view signals) {
    const DbcFile file = parsed("BO_ 1 M: 8 A\n" + std::string(signals));
    return !file.messages.empty() && file.messages[0].signals.back().page_unknown;
}

TEST(DbcFile, ReadsMultiplexedSignalsWhosePageItDoesNotSay) {
    const std::string page = " SG_ P M : 0|8@1+ (1,0) [0|0] \"\" B\n";
    const std::string other = " SG_ Q M : 8|8@1+ (1,0) [0|0] \"\" B\n";
    const std::string bare = " SG_ S m : 16|8@1+ (1,0) [0|0] \"\" B\n";
    const std::string first = " SG_ S m1 : 16|8@1+ (1,0) [0|0] \"\" B\n";
    const std::string own = " SG_ S m1M : 16|8@1+ (1,0) [0|0] \"\" B\n";
    EXPECT_TRUE(page_unknown(bare));
    EXPECT_TRUE(page_unknown(page + bare));
    EXPECT_TRUE(page_unknown(first));
    EXPECT_TRUE(page_unknown(own));
    EXPECT_TRUE(page_unknown(page + other + first));
    EXPECT_FALSE(page_unknown(page + first));
    EXPECT_FALSE(page_unknown(page));
}

TEST(DbcFile, AcceptsOverlappingSignals) {
    EXPECT_EQ(parsed("BO_ 1 M: 8 A\n SG_ A : 0|8@1+ (1,0) [0|0] \"\" B\n"
                     " SG_ B : 4|8@1+ (1,0) [0|0] \"\" B\n")
                  .messages.at(0)
                  .signals.size(),
              2U);
}

TEST(DbcFile, TellsAStandardIdFromTheSameExtendedOne) {
    EXPECT_EQ(parsed("BO_ 256 Short: 8 A\nBO_ 2147483904 Long: 8 A\n").messages.size(), 2U);
}

TEST(DbcFile, FindsNothingByAnUnknownName) {
    const DbcFile file = parsed("BO_ 1 M: 8 A\n");
    EXPECT_EQ(file.find("N"), nullptr);
    EXPECT_EQ(file.find("M")->find("S"), nullptr);
}

}  // namespace
}  // namespace tribus::file_test
