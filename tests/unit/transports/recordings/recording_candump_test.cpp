#include "transports/recordings/candump.h"

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "transports/recordings/recording.h"
#include "transports/recordings/writer.h"

namespace tribus::recording_candump_test {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

Recording parsed(std::string_view content) {
    auto recording = parse_recording(content, "can.log");
    EXPECT_TRUE(recording) << recording.error();
    return recording.value_or(Recording{});
}

/// Returns the frame in a log of one line.
CanFrame frame_of(const std::string& word) {
    const Recording recording = parsed("(1.000000) can0 " + word + "\n");
    EXPECT_EQ(recording.can_frames.size(), 1U) << word;
    return recording.can_frames.empty() ? CanFrame{} : recording.can_frames[0].frame;
}

Bytes data_of(const CanFrame& frame) {
    return {frame.bytes().begin(), frame.bytes().end()};
}

std::string mistake_in(std::string_view content) {
    const auto recording = parse_recording(content, "can.log");
    EXPECT_FALSE(recording) << content;
    return recording ? std::string() : recording.error();
}

std::string mistake_in_frame(const std::string& word) {
    return mistake_in("(1.000000) can0 " + word + "\n");
}

std::string line_of(const CanFrame& frame) {
    std::string text;
    append_candump_line(text, 1s + 249713us, "can0", frame);
    return text;
}

// The form of docs/protocols/can.md, "candump logs".
TEST(CandumpRecording, IsToldByTheParenthesis) {
    const Recording recording = parsed("(1436509052.249713) can0 123#1122\n");
    EXPECT_EQ(recording.kind, RecordingKind::candump);
    EXPECT_TRUE(recording.timed);
    EXPECT_TRUE(recording.bursts.empty());
    ASSERT_EQ(recording.can_frames.size(), 1U);
    EXPECT_EQ(recording.can_frames[0].interface, "can0");
    EXPECT_EQ(recording.can_frames[0].frame.id, 0x123U);
    EXPECT_FALSE(recording.can_frames[0].frame.extended);
    EXPECT_EQ(data_of(recording.can_frames[0].frame), (Bytes{0x11, 0x22}));
}

TEST(CandumpRecording, IsToldBehindCommentsAndBlankLines) {
    EXPECT_EQ(parsed("# bus of the crane\n\n (0.1) can0 123#\r\n").kind, RecordingKind::candump);
}

TEST(CandumpRecording, ZeroIsTheFirstLineAndItsTimeIsKept) {
    const Recording recording = parsed(
        "(1436509052.249713) can0 123#\n"
        "(1436509053.000000) can0 123#\n");
    EXPECT_EQ(recording.log.start, 1436509052s + 249713us);
    ASSERT_EQ(recording.can_frames.size(), 2U);
    EXPECT_EQ(recording.can_frames[0].at, 0us);
    EXPECT_EQ(recording.can_frames[1].at, 750287us);
}

// Newer versions of candump have -N.
TEST(CandumpRecording, ACommentMayNameTheZero) {
    const Recording recording =
        parsed("# zero (1436509052.000000)\n(1436509052.249713) can0 123#\n");
    EXPECT_EQ(recording.log.start, 1436509052s);
    ASSERT_EQ(recording.can_frames.size(), 1U);
    EXPECT_EQ(recording.can_frames[0].at, 249713us);
}

TEST(CandumpRecording, NanosecondsCount) {
    EXPECT_EQ(parsed("(7.000000001) can0 123#\n").log.start, 7s + 1ns);
}

// A small 29-bit id needs eight digits too (docs/protocols/can.md, "candump logs").
TEST(CandumpRecording, EightDigitsAreAnExtendedId) {
    const CanFrame frame = frame_of("00000123#FF");
    EXPECT_EQ(frame.id, 0x123U);
    EXPECT_TRUE(frame.extended);
    EXPECT_EQ(frame_of("1FFFFFFF#").id, kMostExtendedId);
}

TEST(CandumpRecording, RemoteFramesHaveALengthAndNoData) {
    EXPECT_TRUE(frame_of("123#R").remote);
    EXPECT_EQ(frame_of("123#R").length, 0);
    EXPECT_EQ(frame_of("123#R5").length, 5);
    EXPECT_EQ(frame_of("123#R8_D").length, 8);
    EXPECT_EQ(data_of(frame_of("123#R5")), Bytes(5, 0));
}

TEST(CandumpRecording, FdFramesHaveFlags) {
    const CanFrame plain = frame_of("123##0");
    EXPECT_TRUE(plain.fd);
    EXPECT_EQ(plain.length, 0);
    EXPECT_FALSE(plain.bit_rate_switch || plain.error_state_indicator);
    const CanFrame switched = frame_of("123##1AABB");
    EXPECT_TRUE(switched.bit_rate_switch);
    EXPECT_FALSE(switched.error_state_indicator);
    EXPECT_EQ(data_of(switched), (Bytes{0xAA, 0xBB}));
    EXPECT_TRUE(frame_of("123##2").error_state_indicator);
}

// Newer kernels also mark FD frames in the flags (CANFD_FDF).
TEST(CandumpRecording, FdMarkInTheFlagsIsPassedOver) {
    const CanFrame frame = frame_of("123##511");
    EXPECT_TRUE(frame.bit_rate_switch);
    EXPECT_FALSE(frame.error_state_indicator);
    EXPECT_EQ(data_of(frame), Bytes{0x11});
}

TEST(CandumpRecording, FdFramesHoldUpTo64Bytes) {
    std::string word = "123##1";
    for (int i = 0; i < 64; ++i) {
        word += "A5";
    }
    EXPECT_EQ(data_of(frame_of(word)), Bytes(64, 0xA5));
}

TEST(CandumpRecording, PointsMayStandBetweenBytes) {
    EXPECT_EQ(data_of(frame_of("123#11.22.33")), (Bytes{0x11, 0x22, 0x33}));
    EXPECT_EQ(data_of(frame_of("123#1122.33")), (Bytes{0x11, 0x22, 0x33}));
}

TEST(CandumpRecording, RawLengthCodeStillMeansEightBytes) {
    const CanFrame frame = frame_of("123#1122334455667788_E");
    EXPECT_EQ(frame.length, 8);
    EXPECT_EQ(frame, frame_of("123#1122334455667788"));
}

TEST(CandumpRecording, DirectionIsPassedOver) {
    EXPECT_EQ(parsed("(1.0) can0 123#11 R\n(1.0) can0 123#11 T\n").can_frames.size(), 2U);
}

// A controller that went bus-off (CAN_ERR_FLAG | CAN_ERR_BUSOFF), as candump -e logs it.
TEST(CandumpRecording, ErrorFramesAreCountedAndLeftOut) {
    const Recording recording = parsed(
        "(1.000000) can0 20000040#0000000000000000\n"
        "(2.000000) can0 123#11\n");
    EXPECT_EQ(recording.log.error_frames, 1U);
    ASSERT_EQ(recording.can_frames.size(), 1U);
    EXPECT_EQ(recording.can_frames[0].at, 1s);
}

/// Two senders on one vcan, logged live: differences of up to 17.6 ms were seen.
TEST(CandumpRecording, AFrameStampedALittleBeforeTheOneAheadHasItsTime) {
    const Recording recording = parsed(
        "(1.000000) can0 001#\n(1.200000) can0 002#\n(1.100000) can0 003#\n(1.150000) can0 004#\n"
        "(1.250000) can0 005#\n");
    std::vector<Duration> times;
    for (const RecordedCanFrame& frame : recording.can_frames) {
        times.push_back(frame.at);
    }
    EXPECT_EQ(times, (std::vector<Duration>{0ms, 200ms, 200ms, 200ms, 250ms}));
}

TEST(CandumpRecording, TimesMayNotGoFarBack) {
    EXPECT_EQ(mistake_in("(2.000000) can0 123#\n(1.899999) can0 123#\n"),
              "can.log:2:1: the time (1.899999) is more than 100 ms before that of the line above "
              "(sort -s -k1,1 puts a whole log in order)");
}

// `candump -ta can0`, without -L; with -x the direction, with -a letters.
TEST(CandumpRecording, ScreenFormIsReadWithItsTimes) {
    const Recording recording = parsed(
        " (1436509052.249713)  can0  123   [2]  11 22\n"
        " (1436509052.249813)  can0  RX - -  12345678   [0]\n"
        " (1436509052.249913)  can0  123   [8]  11 22 33 44 55 66 77 88   '.\"3DUfw.'\n"
        " (1436509052.250013)  can0  123  [12]  00 01 02 03 04 05 06 07 08 09 0A 0B\n"
        " (1436509052.250113)  can0  123   [4]  remote request\n"
        " (1436509052.250113)  can0  080   [0]  remote request\n"
        " (1436509052.250213)  can0  20000004   [8]  00 08 00 00 00 00 00 00   ERRORFRAME\n");
    ASSERT_EQ(recording.can_frames.size(), 6U);
    EXPECT_EQ(recording.can_frames[0].frame, frame_of("123#1122"));
    EXPECT_EQ(recording.can_frames[0].interface, "can0");
    EXPECT_EQ(recording.can_frames[1].frame, frame_of("12345678#"));
    EXPECT_EQ(recording.can_frames[1].at, 100us);
    EXPECT_EQ(recording.can_frames[2].frame, frame_of("123#1122334455667788"));
    EXPECT_EQ(recording.can_frames[3].frame, frame_of("123##0000102030405060708090A0B"));
    EXPECT_EQ(recording.can_frames[4].frame, frame_of("123#R4"));
    EXPECT_EQ(recording.can_frames[5].frame, frame_of("080#R"));
    EXPECT_EQ(recording.log.error_frames, 1U);
}

constexpr std::string_view kScreen = "  can0  123   [2]  11 22\n  can0  00A   [1]  33\n";

// `candump can0`.
TEST(CandumpRecording, ScreenFormWithoutTimesIsReadWhereNoTimesAreNeeded) {
    EXPECT_EQ(detect_recording_kind(kScreen, "can.log"), RecordingKind::candump);
    OnePiece content(kScreen);
    CandumpFrames frames(content, "can.log", LogTimes::optional);
    const auto first = frames.next();
    ASSERT_TRUE(first && *first);
    EXPECT_EQ((*first)->frame, frame_of("123#1122"));
    const auto second = frames.next();
    ASSERT_TRUE(second && *second);
    EXPECT_EQ((*second)->frame, frame_of("00A#33"));
    EXPECT_EQ((*second)->at, 0us);
}

TEST(CandumpRecording, ScreenFormWithoutTimesIsRefusedWhereTimesAreNeeded) {
    EXPECT_EQ(mistake_in(kScreen),
              "can.log:1:3: a line without a time; a line is (1436509052.249713) can0 123#1122, as "
              "candump -L and candump -l write it");
}

TEST(CandumpRecording, WrongScreenFormIsRefusedWithItsColumn) {
    const auto mistake = [](const std::string& rest) {
        return mistake_in("(1.000000)  can0  " + rest + "\n");
    };
    EXPECT_EQ(mistake("123   [3]  11 22"), "can.log:1:25: the frame has fewer bytes than [3]");
    EXPECT_EQ(mistake("123   [2]  11 2"), "can.log:1:33: the frame has fewer bytes than [2]");
    EXPECT_EQ(mistake("123   [9]  11"), "can.log:1:25: \"[9]\" is not the length of a frame");
    EXPECT_EQ(mistake("123  [999]  11"), "can.log:1:24: \"[999]\" is not the length of a frame");
    EXPECT_TRUE(mistake("12   [1]  11").starts_with("can.log:1:19: \"12\" is not an id; an "));
}

TEST(CandumpRecording, TimeThatIsADateIsRefused) {
    EXPECT_EQ(mistake_in("(2015-07-10 08:17:32.249713) can0 123#\n").substr(0, 40),
              "can.log:1:1: \"(2015-07-10\" is not a time");
}

TEST(CandumpRecording, LineThatEndsEarlyIsRefused) {
    EXPECT_EQ(mistake_in("(1.000000) can0\n").substr(0, 61),
              "can.log:1:1: a time without an interface and a frame; a line ");
}

TEST(CandumpRecording, WordBehindTheFrameIsRefused) {
    EXPECT_EQ(mistake_in("(1.000000) can0 123#11 22\n").substr(0, 37),
              "can.log:1:24: \"22\" after the frame; a");
}

struct WrongFrame {
    const char* word;
    const char* mistake;  ///< from the column on
};

class WrongFrames : public testing::TestWithParam<WrongFrame> {};

TEST_P(WrongFrames, AreRefusedWithTheirColumn) {
    EXPECT_EQ(mistake_in_frame(GetParam().word), std::string("can.log:1:") + GetParam().mistake);
}

INSTANTIATE_TEST_SUITE_P(
    CandumpRecording, WrongFrames,
    testing::Values(
        WrongFrame{"12#",
                   "17: \"12\" is not an id; an 11-bit id is 3 hex digits, a 29-bit id is 8"},
        WrongFrame{"12x#",
                   "17: \"12x\" is not an id; an 11-bit id is 3 hex digits, a 29-bit id is 8"},
        WrongFrame{"800#", "17: \"800\" is above the highest id, 7FF"},
        WrongFrame{"80000123#", "17: \"80000123\" is above the highest id, 1FFFFFFF"},
        WrongFrame{"123#1", "21: \"1\" is not a byte; a byte is two hex digits"},
        WrongFrame{"123#112x", "23: \"2x\" is not a byte; a byte is two hex digits"},
        WrongFrame{"123#112233445566778899",
                   "37: more than 8 bytes in one frame; FD frames have ## after the id"},
        WrongFrame{"123#11_9",
                   "23: \"_9\" is not allowed here; 8 bytes may be followed by _9 to _F"},
        WrongFrame{"123#R9", "22: \"9\" is not allowed here; 8 bytes may be followed by _9 to _F"},
        WrongFrame{"123##", "22: ## is followed by one hex digit of flags, then the data"},
        WrongFrame{"123##1112233445566778899",
                   "22: an FD frame has 0 to 8, 12, 16, 20, 24, 32, 48 or 64 bytes of data, this "
                   "one has 9"}));

// A log that is cut off or scrambled anywhere gives a mistake or frames, but no crash.
TEST(CandumpRecording, AnyDamageIsSurvived) {
    const std::string log = "(1436509052.249713) can0 12345678##31122334455667788.99AABBCC R\n";
    const std::string screen = " (1436509052.249713)  can0  RX - -  123   [2]  11 22\n";
    for (const std::string& line : {log, screen}) {
        for (std::size_t at = 0; at < line.size(); ++at) {
            for (const char character :
                 {'\0', ' ', '#', '(', '_', 'R', 'F', '9', '.', '\n', '\x80'}) {
                std::string damaged = line;
                damaged[at] = character;
                (void)parse_recording(damaged, "can.log", RecordingKind::candump);
                (void)parse_recording(damaged.substr(0, at + 1), "can.log", RecordingKind::candump);
            }
        }
    }
}

TEST(CandumpReader, GoesOnBehindAMistake) {
    CandumpReader reader("can.log");
    EXPECT_TRUE(reader.next("(5.000000) can0 123#11"));
    const auto wrong = reader.next("(6.000000) can0 123#1");
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().substr(0, 12), "can.log:2:21");
    const auto next = reader.next("(5.500000) can0 123#22");
    ASSERT_TRUE(next && *next);
    EXPECT_EQ((*next)->at, 500ms);
}

TEST(CandumpWriter, WritesClassicFrames) {
    EXPECT_EQ(line_of(frame_of("00A#1122")), "(0000000001.249713) can0 00A#1122\n");
    EXPECT_EQ(line_of(frame_of("0000000A#")), "(0000000001.249713) can0 0000000A#\n");
}

TEST(CandumpWriter, RoundsToMicroseconds) {
    std::string text;
    append_candump_line(text, 1999999600ns, "vcan3", CanFrame{});
    EXPECT_EQ(text, "(0000000002.000000) vcan3 000#\n");
}

class CandumpWords : public testing::TestWithParam<const char*> {};

TEST_P(CandumpWords, AreWrittenAsTheyWereRead) {
    EXPECT_EQ(line_of(frame_of(GetParam())),
              std::string("(0000000001.249713) can0 ") + GetParam() + "\n");
}

INSTANTIATE_TEST_SUITE_P(CandumpWriter, CandumpWords,
                         testing::Values("7FF#", "123#0102030405060708", "1FFFFFFF#FF", "123#R",
                                         "123#R3", "00000123#R8", "123##0", "123##1A0",
                                         "123##3000102030405060708090A0B"));

}  // namespace
}  // namespace tribus::recording_candump_test
