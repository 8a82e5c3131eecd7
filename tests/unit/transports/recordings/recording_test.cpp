#include "transports/recordings/recording.h"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "transports/recordings/writer.h"

namespace tribus::recording_test {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

// An i.Bus frame of an FS-iA6B (IBusBM, comment in its source).
const Bytes kIbusFrame{0x20, 0x40, 0xdb, 0x05, 0xdc, 0x05, 0x54, 0x05, 0xdc, 0x05, 0xe8,
                       0x03, 0xd0, 0x07, 0xd2, 0x05, 0xe8, 0x03, 0xdc, 0x05, 0xdc, 0x05,
                       0xdc, 0x05, 0xdc, 0x05, 0xdc, 0x05, 0xdc, 0x05, 0xda, 0xf3};

std::string as_text(const Bytes& bytes) {
    return {bytes.begin(), bytes.end()};
}

Recording parsed(std::string_view content) {
    auto recording = parse_recording(content, "bytes.txt");
    EXPECT_TRUE(recording) << recording.error();
    return recording.value_or(Recording{});
}

std::string mistake_in(std::string_view content) {
    const auto recording = parse_recording(content, "bytes.txt");
    EXPECT_FALSE(recording);
    return recording ? std::string() : recording.error();
}

std::string mistake_in(std::string_view content, RecordingKind kind) {
    const auto recording = parse_recording(content, "bytes.txt", kind);
    EXPECT_FALSE(recording);
    return recording ? std::string() : recording.error();
}

TEST(Recording, EmptyFileHasNoBursts) {
    EXPECT_TRUE(parsed("").bursts.empty());
}

TEST(Recording, FileOfCommentsHasNoBursts) {
    EXPECT_TRUE(parsed("# nothing\n\n   # here\n").bursts.empty());
}

TEST(Recording, RawBytesAreOneBurstWithoutTime) {
    const Recording recording = parsed(as_text(kIbusFrame));
    EXPECT_EQ(recording.kind, RecordingKind::raw);
    ASSERT_EQ(recording.bursts.size(), 1U);
    EXPECT_EQ(recording.bursts[0].bytes, kIbusFrame);
    EXPECT_EQ(recording.bursts[0].start, std::nullopt);
    EXPECT_EQ(recording.bursts[0].damaged, std::vector<bool>(kIbusFrame.size(), false));
}

TEST(Recording, HexLinesAreOneBurstEach) {
    const Recording recording = parsed("20 40 dc 05\n0f E0\n");
    EXPECT_EQ(recording.kind, RecordingKind::hex);
    EXPECT_FALSE(recording.timed);
    ASSERT_EQ(recording.bursts.size(), 2U);
    EXPECT_EQ(recording.bursts[0].bytes, (Bytes{0x20, 0x40, 0xdc, 0x05}));
    EXPECT_EQ(recording.bursts[1].bytes, (Bytes{0x0f, 0xe0}));
}

TEST(Recording, HexToleratesCommentsTabsCarriageReturnsAndAByteOrderMark) {
    const Recording recording =
        parsed("\xEF\xBB\xBF# gr\xC3\xBC\xC3\x9F dich\r\n  20\t40  # header\r\n");
    EXPECT_EQ(recording.kind, RecordingKind::hex);
    ASSERT_EQ(recording.bursts.size(), 1U);
    EXPECT_EQ(recording.bursts[0].bytes, (Bytes{0x20, 0x40}));
}

// The first token of every i.Bus line is two decimal digits.
TEST(Recording, LinesThatAllStartWithTwoDigitsAreHex) {
    EXPECT_EQ(parsed("20 40 dc 05\n20 40 dc 05\n").kind, RecordingKind::hex);
    EXPECT_EQ(parsed("10 11\n12 13\n").kind, RecordingKind::hex);
}

TEST(Recording, TimedHeadingMakesLinesOfTwoDigitsTimed) {
    const Recording recording = parsed("# t_us  bytes\n13 d1 eb\n");
    EXPECT_EQ(recording.kind, RecordingKind::timed);
    ASSERT_EQ(recording.bursts.size(), 1U);
    EXPECT_EQ(recording.bursts[0].start, Duration(13us));
    EXPECT_EQ(recording.bursts[0].bytes, (Bytes{0xd1, 0xeb}));
}

TEST(Recording, RisingNumbersInFrontAreTimesWithoutAnyHeading) {
    const Recording recording = parsed("13 d1 eb\n1146 20 40\n5147.5 20 40\n");
    EXPECT_EQ(recording.kind, RecordingKind::timed);
    EXPECT_TRUE(recording.timed);
    ASSERT_EQ(recording.bursts.size(), 3U);
    EXPECT_EQ(recording.bursts[1].start, Duration(1146us));
    EXPECT_EQ(recording.bursts[2].start, Duration(5147500ns));
}

TEST(Recording, TimesKeepNanosecondsAndASign) {
    const Recording recording = parsed("# t_us\n-2.5 20\n0.0019 40\n7.123 50\n");
    ASSERT_EQ(recording.bursts.size(), 3U);
    EXPECT_EQ(recording.bursts[0].start, Duration(-2500ns));
    EXPECT_EQ(recording.bursts[1].start, Duration(1ns));
    EXPECT_EQ(recording.bursts[2].start, Duration(7123ns));
}

// A slip in a first byte must not make a timed file out of a hex file.
TEST(Recording, AMarkBehindAByteSaysThatItCameDamaged) {
    const Recording recording = parsed("# t_us  bytes\n1146 20 40! dc\n");
    ASSERT_EQ(recording.bursts.size(), 1U);
    EXPECT_EQ(recording.bursts[0].bytes, (std::vector<std::uint8_t>{0x20, 0x40, 0xdc}));
    EXPECT_EQ(recording.bursts[0].damaged, (std::vector<bool>{false, true, false}));
}

TEST(Recording, OneLongTokenAmongHexLinesIsAMistakeNotATime) {
    EXPECT_EQ(mistake_in("20 40 dc\n204 0d\n20 40 dc\n"),
              "bytes.txt:2:1: \"204\" is not a byte; a byte is two hex digits, with a space "
              "between bytes: 20 40 dc 05");
}

TEST(Recording, SaysWhereAByteIsWrong) {
    EXPECT_EQ(mistake_in("0f e0\n0f e0 # fine\n0f 0x100 00\n"),
              "bytes.txt:3:4: \"0x100\" is not a byte; a byte is two hex digits, with a space "
              "between bytes: 20 40 dc 05");
}

/// As people paste dumps of programs and of analysers.
TEST(Recording, ReadsHexWithoutSpacesAndWithAPrefix) {
    const std::vector<std::uint8_t> bytes{0x20, 0x40, 0xDC, 0x05};
    for (const char* const text : {"2040dc05", "2040DC05\n", "20 40dc 05", "0x20 0x40 0xDC 0x5",
                                   "0x20, 0x40, 0xdc, 0x05,", "0X20 40 0xdc 05"}) {
        const Recording recording = parsed(text);
        EXPECT_EQ(recording.kind, RecordingKind::hex) << text;
        ASSERT_EQ(recording.bursts.size(), 1U) << text;
        EXPECT_EQ(recording.bursts[0].bytes, bytes) << text;
    }
    EXPECT_EQ(parsed("# t_us\n1146 2040dc05\n").bursts.at(0).bytes, bytes);
    EXPECT_EQ(parsed("0x20 0xDC!\n").bursts.at(0).damaged, (std::vector<bool>{false, true}));
}

TEST(Recording, RefusesHalfBytesAndMarksOfSeveral) {
    for (const char* const word :
         {"204", "2040dc0", "2040!", "0x", "0x2040", "2g", "0x2g", "x20"}) {
        EXPECT_EQ(mistake_in(std::string("20 40 ") + word + "\n"),
                  "bytes.txt:1:7: \"" + std::string(word) +
                      "\" is not a byte; a byte is two hex digits, with a space between bytes: "
                      "20 40 dc 05");
    }
}

TEST(Recording, RefusesTimesThatGoBack) {
    EXPECT_EQ(
        mistake_in("# t_us\n10 20\n9 20\n"),
        "bytes.txt:3:1: the time 9 is before that of the line above; times must not decrease");
}

TEST(Recording, RefusesATimeWithoutBytes) {
    EXPECT_EQ(mistake_in("1146\n"),
              "bytes.txt:1:1: a time without bytes; the bytes of the burst follow it");
}

TEST(Recording, RefusesATimeThatDoesNotFit) {
    EXPECT_EQ(
        mistake_in("# t_us\n9999999999999999 20\n"),
        "bytes.txt:2:1: \"9999999999999999\" is not a time; a line of a timed recording starts "
        "with decimal microseconds: 1146 20 40 dc 05");
}

// Text with one invalid byte may be a damaged file; as "raw" it would be misread.
TEST(Recording, RefusesTextWithAStrayControlCharacter) {
    const std::string content =
        "20 40 dc 05 dc 05 dc 05\n20 40 \x01"
        "dc 05 dc 05 dc 05\n";
    EXPECT_EQ(mistake_in(content),
              "bytes.txt:2:7: a byte that is not text in a file of text; correct it, or say that "
              "the file holds raw bytes");
}

TEST(Recording, NamedKindOverridesTheContent) {
    const auto recording = parse_recording("20 40", "bytes.txt", RecordingKind::raw);
    ASSERT_TRUE(recording);
    EXPECT_EQ(recording->bursts.at(0).bytes, (Bytes{'2', '0', ' ', '4', '0'}));
    EXPECT_EQ(
        mistake_in("0f 20", RecordingKind::timed),
        "bytes.txt:1:1: \"0f\" is not a time; a line of a timed recording starts with decimal "
        "microseconds: 1146 20 40 dc 05");
}

constexpr std::string_view kSaleaeHeading = "Time [s],Value,Parity Error,Framing Error\n";

TEST(Recording, SaleaeBytesThatLieCloseAreOneBurst) {
    const Recording recording = parsed(std::string(kSaleaeHeading) +
                                       "0,0x0F,,\n0.00012,0x11,,\n0.000480125,0xA8,,\n5E-04,7,,\n");
    EXPECT_EQ(recording.kind, RecordingKind::saleae);
    EXPECT_TRUE(recording.timed);
    ASSERT_EQ(recording.bursts.size(), 2U);
    EXPECT_EQ(recording.bursts[0].start, Duration(0us));
    EXPECT_EQ(recording.bursts[0].bytes, (Bytes{0x0f, 0x11}));
    EXPECT_EQ(recording.bursts[1].start, Duration(480125ns));
    EXPECT_EQ(recording.bursts[1].bytes, (Bytes{0xa8, 0x07}));
}

TEST(Recording, SaleaeErrorColumnsMarkDamagedBytes) {
    const Recording recording = parsed(std::string(kSaleaeHeading) +
                                       "0,0x0F,,\n0.0001,0x11,Error,\r\n0.0002,0x12,,Error\r\n");
    ASSERT_EQ(recording.bursts.size(), 1U);
    EXPECT_EQ(recording.bursts[0].damaged, (std::vector<bool>{false, true, true}));
}

TEST(Recording, RefusesTheExportOfAnotherAnalyser) {
    EXPECT_EQ(mistake_in("Time [s],Packet ID,MOSI,MISO\n0,0,0x01,0x02\n"),
              "bytes.txt:1:1: not the export of a serial decoder, whose first line is Time "
              "[s],Value,Parity Error,Framing Error");
}

TEST(Recording, SaysWhereASaleaeRowIsWrong) {
    const std::string head(kSaleaeHeading);
    EXPECT_EQ(mistake_in(head + "0,0x0F,,\n0.1,0x100,,\n"),
              "bytes.txt:3:5: \"0x100\" is not a byte; export with hexadecimal values: 0x0F");
    EXPECT_EQ(mistake_in(head + "1,0x0F,,\n0.9,0x0F,,\n"),
              "bytes.txt:3:1: \"0.9\" is before the time of the row above; times are seconds and "
              "must not decrease");
    EXPECT_EQ(mistake_in(head + "0,0x0F\n"),
              "bytes.txt:2:1: a row needs four columns: Time [s],Value,Parity Error,Framing Error");
    EXPECT_EQ(mistake_in(head + "nan,0x0F,,\n"),
              "bytes.txt:2:1: \"nan\" is not a time; times are seconds and must not decrease");
}

TEST(Recording, LooksRawAfterOneFrameAndNotForText) {
    EXPECT_TRUE(looks_raw(as_text(kIbusFrame)));
    EXPECT_FALSE(looks_raw("20 40 dc 05"));
    EXPECT_FALSE(looks_raw(""));
}

TEST(RecordingWriter, HexLineReadsBack) {
    std::string text;
    append_hex_line(text, kIbusFrame);
    EXPECT_EQ(text.substr(0, 12), "20 40 db 05 ");
    EXPECT_EQ(parsed(text).bursts.at(0).bytes, kIbusFrame);
}

TEST(RecordingWriter, TimedLinesHaveWholeMicroseconds) {
    std::string text(kTimedHeading);
    append_timed_line(text, Duration(-3us), Bytes{0x03});
    append_timed_line(text, Duration(13us), Bytes{0xd1, 0xeb});
    append_timed_line(text, Duration(1146050ns), Bytes{0x20});
    append_timed_line(text, Duration(1146950ns), Bytes{0x21});
    EXPECT_EQ(text, "# t_us  bytes\n-3 03\n13 d1 eb\n1146 20\n1147 21\n");
    EXPECT_EQ(parsed(text).bursts.at(1).start, Duration(13us));
}

}  // namespace
}  // namespace tribus::recording_test
