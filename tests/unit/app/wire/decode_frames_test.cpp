#include "app/wire/decode_frames.h"

#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/cli/exit_status.h"
#include "tests/support/outcome.h"
#include "tests/support/sbus_frames.h"

namespace tribus::decode_frames_test {
namespace {

using test::kCentred24;
using test::Outcome;
using test::outcome_of;

// i.Bus, 14 channels (IBusBM, comment in its source).
constexpr std::string_view kIbus14 =
    "20 40 db 05 dc 05 54 05 dc 05 e8 03 d0 07 d2 05 e8 03 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 da "
    "f3";
// i.Bus of an IA6, 31 bytes (Betaflight's unit test).
constexpr std::string_view kIbusIa6 =
    "55 00 00 01 00 02 00 03 00 04 00 05 00 06 00 07 00 08 00 09 00 0a 00 0b 00 0c 00 0d 00 5b 00";
// SBUS of a FrSky TFR8SB (laneboysrc/rc-light-controller).
constexpr std::string_view kSbus =
    "0f 04 1c a1 43 0b 48 40 04 7a 10 2c 00 04 20 58 c0 13 07 38 00 10 80 00 00";
// SBUS with all channels at 992, which has headers in its payload; flags 0C.
constexpr std::string_view kSbusLost =
    "0f e0 03 1f f8 c0 07 3e f0 81 0f 7c e0 03 1f f8 c0 07 3e f0 81 0f 7c 0c 00";

Outcome decoded(const std::string& content, std::string_view protocol, DecodeFormat format) {
    const auto recording = parse_recording(content, "bytes.txt");
    const auto uses = choose_protocols(protocol, SettingScope::input, {});
    EXPECT_TRUE(recording && uses);
    return outcome_of([&](std::ostream& results, std::ostream& messages) {
        const DecodeOutput output{format, recording->kind, results, messages};
        RecordingInMemory source(*recording);
        return decode_frames(source, of_shape(*uses, WireShape::bytes), output);
    });
}

std::string lines_of(std::initializer_list<std::string_view> lines) {
    std::string text;
    for (const std::string_view line : lines) {
        text.append(line).append("\n");
    }
    return text;
}

TEST(Decode, NamesSbusWith24Channels) {
    for (const char* const protocol : {"sbus", "auto", "ibus"}) {
        const Outcome outcome =
            decoded(lines_of({kCentred24, kCentred24, kCentred24}), protocol, DecodeFormat::json);
        EXPECT_NE(outcome.messages.find("tribus: it has 3 frames of FrSky's SBUS with 24 channels "
                                        "(36 bytes), which tribus does not read; set the receiver "
                                        "to 16 channels\n"),
                  std::string::npos)
            << protocol << ": " << outcome.messages;
    }
}

TEST(Decode, JsonEndsWithASummary) {
    const Outcome outcome = decoded(lines_of({kIbus14}), "ibus", DecodeFormat::json);
    EXPECT_EQ(outcome.status, kExitFine);
    EXPECT_EQ(outcome.results,
              "{\"protocol\":\"ibus\",\"channels\":[1499,1500,1364,1500,1000,2000,1490,1000,1500,"
              "1500,1500,1500,1500,1500,null,null,null,null],\"frame_lost\":false,\"failsafe\":"
              "false}\n"
              "{\"summary\":{\"bytes\":32,\"frames\":1,\"rejected\":{\"checksum\":0,\"damaged\":0,"
              "\"ibus2\":0,\"length\":0},\"skipped_bytes\":0,\"input\":\"hex\"}}\n");
}

TEST(Decode, CsvHasEmptyCellsAndKeepsTheSummaryOut) {
    const Outcome outcome = decoded(lines_of({kIbus14}), "ibus", DecodeFormat::csv);
    EXPECT_EQ(outcome.results,
              "t_us,ch1,ch2,ch3,ch4,ch5,ch6,ch7,ch8,ch9,ch10,ch11,ch12,ch13,ch14,ch15,ch16,ch17,"
              "ch18,frame_lost,failsafe\n"
              ",1499,1500,1364,1500,1000,2000,1490,1000,1500,1500,1500,1500,1500,1500,,,,,0,0\n");
    EXPECT_EQ(outcome.messages, "1 frame in 32 bytes, 0 bytes skipped, rejected: none\n");
}

TEST(Decode, TextShowsFlagsAndFooter) {
    const Outcome outcome = decoded(lines_of({kSbusLost}), "sbus", DecodeFormat::text);
    ASSERT_EQ(outcome.lines().size(), 3U);
    EXPECT_EQ(outcome.lines()[1],
              "           - sbus     1500 1500 1500 1500 1500 1500 1500 1500 1500 1500 1500 1500 "
              "1500 1500 1500 1500 1000 1000  frame-lost failsafe  footer=0x00");
}

TEST(Decode, TimeIsThatOfTheFramesFirstByte) {
    // Two frames in one burst: the second starts 25 bytes of 120 us later, after two more bytes.
    const Outcome outcome = decoded("# t_us\n1000 " + lines_of({kSbus}) + "9000 " +
                                        std::string(kSbus) + " " + std::string(kSbus) + "\n",
                                    "sbus", DecodeFormat::csv);
    ASSERT_EQ(outcome.lines().size(), 4U);
    EXPECT_EQ(outcome.lines()[1].substr(0, 5), "1000,");
    EXPECT_EQ(outcome.lines()[2].substr(0, 5), "9000,");
    EXPECT_EQ(outcome.lines()[3].substr(0, 6), "12000,");
}

TEST(Decode, FrameThatIsSplitOverBurstsHasTheTimeOfTheFirst) {
    const std::string frame(kIbus14);
    const Outcome outcome =
        decoded("# t_us\n100 00 00 " + frame.substr(0, 30) + "\n2000 " + frame.substr(30) + "\n",
                "ibus", DecodeFormat::csv);
    ASSERT_EQ(outcome.lines().size(), 2U);
    // Two bytes of 86.8 us after the start of the burst.
    EXPECT_EQ(outcome.lines()[1].substr(0, 4), "274,");
}

/// The protocols of the frames, in the order of the lines.
std::vector<std::string> protocols_of(const Outcome& outcome) {
    std::vector<std::string> names;
    for (const std::string& line : outcome.lines()) {
        const std::size_t at = line.find("\"protocol\":\"");
        if (at != std::string::npos) {
            names.push_back(line.substr(at + 12, line.find('"', at + 12) - at - 12));
        }
    }
    return names;
}

TEST(Decode, BytesOfAFrameOfTheBestProtocolAreNoFrameOfAnother) {
    // An i.Bus frame whose third to eleventh channels are the bytes of an SBUS frame.
    const Outcome outcome = decoded(lines_of({kIbus14, "20 40 dc 05 dc", kSbus, "64 f9", kIbus14}),
                                    "auto", DecodeFormat::json);
    EXPECT_EQ(protocols_of(outcome), (std::vector<std::string>{"ibus", "ibus", "ibus"}));
}

TEST(Decode, FramesOfSeveralProtocolsComeInTheOrderOfTheirFirstBytes) {
    const std::string frame(kIbus14);
    const Outcome outcome =
        decoded(lines_of({frame.substr(0, 30), kSbus, frame.substr(30), kIbus14, kSbus, kIbus14}),
                "auto", DecodeFormat::json);
    EXPECT_EQ(protocols_of(outcome),
              (std::vector<std::string>{"ibus", "sbus", "ibus", "sbus", "ibus"}));
}

TEST(Decode, DamagedByteCostsItsFrameOnly) {
    auto recording = parse_recording(lines_of({kIbus14, kIbus14}), "bytes.txt");
    ASSERT_TRUE(recording);
    recording->bursts[0].damaged[7] = true;
    const auto uses = choose_protocols("ibus", SettingScope::input, {});
    std::ostringstream results;
    const DecodeOutput output{DecodeFormat::json, recording->kind, results, results};
    RecordingInMemory source(*recording);
    decode_frames(source, of_shape(*uses, WireShape::bytes), output);
    EXPECT_NE(results.str().find("\"bytes\":64,\"frames\":1,\"rejected\":{\"checksum\":0,"
                                 "\"damaged\":1,\"ibus2\":0,\"length\":0},\"skipped_bytes\":32"),
              std::string::npos)
        << results.str();
}

// Bytes that a Futaba R7003SB sends 2 ms after each frame; bolderflight/sbus, issue 79.
std::string r7003sb_recording() {
    std::string text = "# t_us bytes\n";
    for (int i = 0; i < 100; ++i) {
        text += fmt::format("{} {}\n{} 00 03 c0 33 00\n", 14'000 * i, kSbus, 14'000 * i + 5000);
    }
    return text;
}

TEST(Decode, PausesOfATimedRecordingCountAsOnALine) {
    const Outcome outcome = decoded(r7003sb_recording(), "sbus", DecodeFormat::json);
    ASSERT_EQ(outcome.lines().size(), 101U);
    EXPECT_NE(outcome.lines().back().find("\"frames\":100,\"rejected\":{\"framing\":0,"),
              std::string::npos)
        << outcome.lines().back();
}

TEST(Decode, AFrameIsNotPutTogetherOverAPauseOfATimedRecording) {
    const std::string torn(kSbus.substr(0, 3 * 23 - 1));
    const Outcome outcome =
        decoded(fmt::format("# t_us bytes\n0 {0}\n14000 {0}\n28000 {1}\n42000 {0}\n56000 {0}\n",
                            kSbus, torn),
                "sbus", DecodeFormat::json);
    ASSERT_EQ(outcome.lines().size(), 5U);
    EXPECT_EQ(outcome.results.find("\"failsafe\":true"), std::string::npos);
}

TEST(Decode, AutoFindsTheProtocol) {
    const Outcome outcome = decoded(lines_of({kSbus, kSbusLost}), "auto", DecodeFormat::json);
    ASSERT_EQ(outcome.lines().size(), 3U);
    EXPECT_NE(outcome.lines()[0].find("\"protocol\":\"sbus\""), std::string::npos);
}

TEST(Decode, AutoFindsTheFrameOfEveryLineInTheOrderOfTheFile) {
    const Outcome outcome = decoded(lines_of({kIbus14, kSbus, kIbusIa6, kSbusLost, kIbus14}),
                                    "auto", DecodeFormat::text);
    ASSERT_EQ(outcome.lines().size(), 7U);
    EXPECT_EQ(outcome.lines()[1].substr(13, 4), "ibus");
    EXPECT_EQ(outcome.lines()[2].substr(13, 4), "sbus");
    EXPECT_EQ(outcome.lines()[3].substr(13, 4), "ibus");
    EXPECT_EQ(outcome.lines()[4].substr(13, 4), "sbus");
    EXPECT_EQ(outcome.lines()[5].substr(13, 4), "ibus");
    EXPECT_EQ(outcome.lines()[6], "5 frames in 145 bytes, 0 bytes skipped, rejected: none");
}

TEST(Decode, AutoSaysSoWhenNoProtocolFits) {
    const Outcome outcome = decoded("01 02 03\n", "auto", DecodeFormat::json);
    EXPECT_EQ(outcome.status, kExitFailed);
    EXPECT_TRUE(outcome.messages.starts_with("tribus: no frame of ibus or sbus"));
    EXPECT_TRUE(outcome.messages.ends_with(" in 3 bytes\n")) << outcome.messages;
    EXPECT_EQ(outcome.results,
              "{\"summary\":{\"bytes\":3,\"frames\":0,\"rejected\":{},\"skipped_bytes\":3,"
              "\"input\":\"hex\"}}\n");
}

TEST(Decode, NamesTheProtocolThatFindsFramesWhereTheAskedOneFindsNone) {
    const Outcome outcome = decoded(lines_of({kIbus14, kIbus14}), "sbus", DecodeFormat::json);
    EXPECT_EQ(
        outcome.messages,
        "tribus: no frame of sbus in 64 bytes; protocols that find frames: ibus (2 frames)\n");
}

TEST(Decode, SaysThatNoProtocolFindsAFrame) {
    const Outcome outcome = decoded("12 34 56\n", "sbus", DecodeFormat::json);
    EXPECT_EQ(outcome.messages,
              "tribus: no frame of sbus in 3 bytes; no other protocol finds any\n");
}

TEST(Decode, NamesTheSensorBusWhereItsFramesAreAskedAsChannels) {
    // Discover and its answer at address 1 (docs/protocols/ibus.md, "Sensor bus: frames").
    const Outcome outcome = decoded("04 81 7a ff\n04 81 7a ff\n", "sbus", DecodeFormat::json);
    EXPECT_EQ(outcome.messages,
              "tribus: no frame of sbus in 8 bytes; protocols that find frames: ibus-sensor (2 "
              "frames)\n");
}

TEST(Decode, StreamWithoutAFrameNamesTheProtocolThatFindsSome) {
    const auto recording = parse_recording(lines_of({kIbus14, kIbus14}), "bytes.txt");
    ASSERT_TRUE(recording);
    const auto uses = choose_protocols("sbus", SettingScope::input, {});
    std::vector<Burst> bursts = recording->bursts;
    const auto read = [&] {
        if (bursts.empty()) {
            return std::string();
        }
        const Burst burst = bursts.back();
        bursts.pop_back();
        return std::string(burst.bytes.begin(), burst.bytes.end());
    };
    std::ostringstream results;
    std::ostringstream messages;
    const DecodeOutput output{DecodeFormat::json, RecordingKind::raw, results, messages};
    FrameDecoding decoding(uses->front(), output);
    decode_stream(read, decoding, results, messages);
    EXPECT_EQ(
        messages.str(),
        "tribus: no frame of sbus in 64 bytes; protocols that find frames: ibus (2 frames)\n");
}

TEST(Decode, EmptyInputIsFine) {
    EXPECT_EQ(decoded("", "auto", DecodeFormat::json).status, kExitFine);
}

TEST(Decode, StreamPrintsAFrameBeforeTheNextBytesAreRead) {
    const auto recording = parse_recording(lines_of({kIbus14}), "bytes.txt");
    ASSERT_TRUE(recording);
    const std::string frame(recording->bursts[0].bytes.begin(), recording->bursts[0].bytes.end());
    const auto uses = choose_protocols("ibus", SettingScope::input, {});
    std::ostringstream results;
    const DecodeOutput output{DecodeFormat::csv, RecordingKind::raw, results, results};
    std::vector<std::string> chunks{frame.substr(0, 9), frame.substr(9), ""};
    std::vector<std::size_t> printed;
    std::size_t next = 0;
    const auto read = [&] {
        printed.push_back(results.str().size());
        return chunks[next++];
    };
    FrameDecoding decoding(uses->front(), output);
    EXPECT_EQ(decode_stream(read, decoding, results, results), kExitFine);
    ASSERT_EQ(printed.size(), 3U);
    EXPECT_EQ(printed[1], printed[0]);
    EXPECT_GT(printed[2], printed[1]);
}

}  // namespace
}  // namespace tribus::decode_frames_test
