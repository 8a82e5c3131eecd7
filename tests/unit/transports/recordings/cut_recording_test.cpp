#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "transports/recordings/pieces.h"
#include "transports/recordings/recording.h"
#include "transports/recordings/recording_source.h"
#include "transports/recordings/text.h"
#include "transports/recordings/time_steps.h"

/// Recordings as a loss of power, or another use of the recorder, leaves them.
namespace tribus::cut_recording_test {
namespace {

using namespace std::string_literals;
using namespace std::chrono_literals;

Recording parsed(std::string_view content) {
    auto recording = parse_recording(content, "f");
    EXPECT_TRUE(recording) << recording.error();
    return recording.value_or(Recording{});
}

std::string mistake_in(std::string_view content) {
    const auto recording = parse_recording(content, "f");
    EXPECT_FALSE(recording);
    return recording ? std::string() : recording.error();
}

constexpr std::string_view kCutByte =
    "is not a byte; a byte is two hex digits, with a space between bytes: 20 40 dc 05; the file "
    "ends in this line, as a loss of power leaves it; the lines above are read";

TEST(CutRecording, WithBytesIsReadUpToTheLineThatIsCut) {
    for (const std::string start : {"", "0 ", "9000 "}) {
        const bool timed = !start.empty();
        const std::string heading = timed ? "# t_us  bytes\n" : "# bytes\n";
        const Recording recording = parsed(heading + start + "20 40 db\n" + start + "20 4");
        ASSERT_EQ(recording.bursts.size(), 1U);
        EXPECT_EQ(recording.bursts[0].bytes.size(), 3U);
        EXPECT_EQ(recording.rest.value_or("").substr(0, 4), "f:3:");
        EXPECT_TRUE(recording.rest.value_or("").ends_with(kCutByte)) << *recording.rest;
    }
}

TEST(CutRecording, WithCanFramesIsReadUpToTheLineThatIsCut) {
    const Recording recording = parsed("(1.0) can0 300#00\n(1.01) can0 304#CB0");
    EXPECT_EQ(recording.can_frames.size(), 1U);
    EXPECT_EQ(recording.rest,
              "f:2:19: \"0\" is not a byte; a byte is two hex digits; the file ends in this line, "
              "as a loss of power leaves it; the lines above are read");
}

TEST(CutRecording, FromAnAnalyserIsReadUpToTheRowThatIsCut) {
    const Recording recording =
        parsed("Time [s],Value,Parity Error,Framing Error\n0.001,0x20,,\n0.1,0x40,,\n0.2,0x");
    EXPECT_EQ(recording.bursts.size(), 2U);
    EXPECT_TRUE(recording.rest.has_value());
}

/// It may be mistyped: nothing is lost by saying so.
TEST(CutRecording, WithNothingAboveTheCutIsAMistake) {
    EXPECT_EQ(mistake_in("20 4").substr(0, 13), "f:1:4: \"4\" is");
    EXPECT_EQ(mistake_in("(1.0) can0 304#CB0").substr(0, 8), "f:1:18: ");
}

TEST(CutRecording, WithAMistakeInALineThatHasAnEndIsRefused) {
    EXPECT_EQ(mistake_in("20 40\n20 4\n").substr(0, 7), "f:2:4: ");
}

TEST(CutRecording, EndsAtNulBytesWhateverTheirNumber) {
    for (const std::size_t count : {1U, 100U, 10'000U}) {
        const Recording bytes = parsed("0 20 40\n7000 20 40\n14000 2" + std::string(count, '\0'));
        EXPECT_EQ(bytes.kind, RecordingKind::timed);
        EXPECT_EQ(bytes.bursts.size(), 2U);
        EXPECT_EQ(bytes.rest,
                  "f:3:8: NUL bytes from here on, as a loss of power leaves them; the lines above "
                  "are read");
        const Recording log = parsed("(1.0) can0 300#00\n" + std::string(count, '\0'));
        EXPECT_EQ(log.kind, RecordingKind::candump);
        EXPECT_EQ(log.can_frames.size(), 1U);
        EXPECT_EQ(log.rest.value_or("").substr(0, 8), "f:2:1: N");
    }
}

TEST(CutRecording, WithRawBytesMayEndWithNulBytes) {
    const std::string sbus = "\x0f"s + std::string(22, '\x04') + "\n\0\0"s;
    EXPECT_EQ(parsed(sbus).kind, RecordingKind::raw);
    EXPECT_EQ(parsed(std::string(100, '\0')).kind, RecordingKind::raw);
}

TEST(RecordingLine, IsRefusedIfLongerThanAMebibyte) {
    std::string line = "20 40\n";
    while (line.size() <= recording_text::kLongestLine + 6) {
        line += "20 40 dc 05 ";
    }
    for (const std::string_view end : {"", "\n20 40\n"}) {
        EXPECT_EQ(mistake_in(line + std::string(end)),
                  "f:2:1: a line of more than 1048576 characters; write one burst a line");
    }
}

/// `candump -td can0` with frames each 10 ms.
std::string differences(int lines, int jitter_us) {
    std::string log = "(000.000000) can0 123#11\n";
    for (int line = 1; line < lines; ++line) {
        log += "(000.0" + std::to_string(10000 + (line % 3 - 1) * jitter_us) + ") can0 123#11\n";
    }
    return log;
}

TEST(TimesOfCandump, ThatAreDifferencesAreRefused) {
    for (const int lines : {6, 20, 500}) {
        for (const int jitter : {0, 12, 900}) {
            EXPECT_NE(mistake_in(differences(lines, jitter)).find("candump -td"), std::string::npos)
                << lines << " " << jitter;
        }
    }
    EXPECT_NE(mistake_in("(000.000000) can0 1F0#\n(000.500000) can0 1F0#\n(000.300000) can0 1F0#\n")
                  .find("candump -td"),
              std::string::npos);
}

/// `candump -tz`; frames of two senders may change places by some milliseconds.
TEST(TimesOfCandump, ThatCountFromTheFirstLineAreRead) {
    std::string log;
    for (int line = 0; line < 100; ++line) {
        const int us = 100'000 + line * 1000 - (line % 10 == 9 ? 1500 : 0);
        log += "(000." + std::to_string(us) + ") can0 123#11\n";
    }
    EXPECT_EQ(parsed(log).can_frames.size(), 100U);
    EXPECT_EQ(parsed("(000.000000) can0 123#\n(000.000000) can0 124#\n(000.000000) can0 125#\n")
                  .can_frames.size(),
              3U);
}

std::optional<TimeGap> gap_in(std::string_view content) {
    OnePiece piece(content);
    const auto kind = detect_recording_kind(content, "f");
    RecordingInPieces recording(piece, "f", kind.value());
    EXPECT_TRUE(recording.judge());
    return recording.gap();
}

TEST(TimeGaps, HaveTheirLineIfLongerThanAnHour) {
    const auto log = gap_in("(10.0) can0 1F0#\n# a comment\n(1700000000.0) can0 1F0#\n");
    ASSERT_TRUE(log);
    EXPECT_EQ(gap_text("f", *log),
              "f:3:1: the times jump by 53.8 years here, and all of that would be played; make two "
              "recordings of it, of the lines above and from this one on");
    const auto bytes = gap_in("# t_us  bytes\n0 20\n7000 20\n9000000000 20\n");
    ASSERT_TRUE(bytes);
    EXPECT_EQ(bytes->line, 4U);
    EXPECT_EQ(gap_text("f", *bytes).substr(0, 37), "f:4:1: the times jump by 2.4 hours he");
    EXPECT_FALSE(gap_in("# t_us  bytes\n0 20\n3600000000 20\n"));
}

/// `replay` begins with the first burst, `simulate` with the start of the recording.
TEST(TimeGaps, InFrontOfTheFirstBurstAreKeptApart) {
    constexpr std::string_view kLate = "# t_us  bytes\n90000000000 20\n90000007000 20\n";
    OnePiece piece(kLate);
    RecordingInPieces recording(piece, "f", detect_recording_kind(kLate, "f").value());
    EXPECT_TRUE(recording.judge());
    EXPECT_FALSE(recording.gap());
    ASSERT_TRUE(recording.late_start());
    EXPECT_EQ(late_start_text("f", *recording.late_start()),
              "f:2:1: the first line is 25.0 hours after the start of the recording, and all of "
              "that would be played; subtract its time from each time");
}

}  // namespace
}  // namespace tribus::cut_recording_test
