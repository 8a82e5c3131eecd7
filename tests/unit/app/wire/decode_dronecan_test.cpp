#include "app/wire/decode_dronecan.h"

#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/exit_status.h"
#include "app/wire/frames/frame_json.h"
#include "tests/support/outcome.h"

namespace tribus::decode_dronecan_test {
namespace {

using nlohmann::json;
using test::Outcome;
using test::outcome_of;

/// The eight worked examples of docs/protocols/can.md, "DroneCAN: worked examples", in their order.
/// The last one, with 18 channels in an FD frame, is rcinput_18ch_fd of the vectors.
constexpr std::string_view kExamples =
    "(1.000000) can0 0804742A#13C30100C80E8385\n"
    "(1.000130) can0 0804742A#4C4B04145785DC25\n"
    "(1.000260) can0 0804742A#5406A460876C7D05\n"
    "(1.000390) can0 0804742A#07DC3DC7DB5DD525\n"
    "(1.000520) can0 0804742A#DE5045\n"
    "(1.020000) can0 0804742A#1F670200000DC59F\n"
    "(1.020130) can0 0804742A#DC5843DC5DC5DC3F\n"
    "(1.020260) can0 0804742A#5DC5DC5DC5DC5D1F\n"
    "(1.020390) can0 0804742A#C5DC5DC5DC5DC53F\n"
    "(1.020520) can0 0804742A#DC505F\n"
    "(1.030000) can0 0803F20A#61B7010000000282\n"
    "(1.030130) can0 0803F20A#0000BC0300003C22\n"
    "(1.030260) can0 0803F20A#0400003842\n"
    "(1.040000) can0 0804060A#0003FDF0080010C9\n"
    "(1.050000) can0 1801552A#D2040000000000CC\n"
    "(1.060000) can0 18D45D00#01001122334455C0\n"
    "(1.070000) can0 1801AAFF#C3\n"
    "(1.080000) can0 "
    "0804742A##10500E124AB00405D07604F0A80810DA0F30CC12513E1171701491A21BB1941C00000"
    "00000000000000000000000000D1\n";

Outcome decoded(std::string_view log, DecodeFormat format,
                std::optional<std::size_t> columns = std::nullopt) {
    const auto recording = parse_recording(log, "can.log", RecordingKind::candump);
    EXPECT_TRUE(recording) << recording.error();
    return outcome_of([&](std::ostream& results, std::ostream& messages) {
        TransferDecoding decoding(columns, {format, RecordingKind::candump, results, messages});
        RecordingInMemory source(*recording);
        return decode_recording(source, decoding, messages);
    });
}

std::vector<json> objects(std::string_view log) {
    std::vector<json> found;
    for (const std::string& line : decoded(log, DecodeFormat::json).lines()) {
        found.push_back(json::parse(line));
    }
    return found;
}

/// Returns the text of the only transfer in a log.
std::string text_of(std::string_view log) {
    const auto lines = decoded(log, DecodeFormat::text).lines();
    return lines.size() > 2 ? lines[1] : "";
}

using Lines = std::vector<std::string>;

TEST(DecodeDroneCan, TheWorkedExamplesAsText) {
    const Outcome outcome = decoded(kExamples, DecodeFormat::text);
    EXPECT_EQ(outcome.status, kExitFine);
    EXPECT_EQ(outcome.messages, "");
    EXPECT_EQ(
        outcome.lines(),
        (Lines{
            "        t_us     node prio  id  transfer",
            "         520       42    8   5  dronecan.sensors.rc.RCInput  status 1, quality 200, "
            "id 0, rcin [1000 1100 1200 1300 1400 1500 1600 1700 1800 1900 2000 988 2012 1499 1501 "
            "1502] us",
            "       20520       42    8  31  dronecan.sensors.rc.RCInput  status 2, quality 0, "
            "id 0, rcin [1500 1500 900 1500 1500 1500 1500 1500 1500 1500 1500 1500 1500 1500 1500 "
            "1500] us  failsafe",
            "       30260       10    8   2  uavcan.equipment.actuator.ArrayCommand  commands "
            "[{actuator_id 1, command_type 0, command_value 0}, {actuator_id 2, command_type 0, "
            "command_value -1}, {actuator_id 3, command_type 0, command_value 1}, {actuator_id 4, "
            "command_type 0, command_value 0.5}]",
            "       40000       10    8   9  uavcan.equipment.esc.RawCommand  cmd [0 8191 -8192 "
            "4096]",
            "       50000       42   24  12  uavcan.protocol.NodeStatus  uptime_sec 1234 s, health "
            "0, mode 0, sub_mode 0, vendor_specific_status_code 0",
            "       60000     anon   24   0  uavcan.protocol.dynamic_node_id.Allocation  node_id "
            "0, first_part_of_unique_id true, unique_id \"001122334455\"",
            "       70000  127->42   24   3  uavcan.protocol.GetNodeInfo request",
            "       80000       42    8  17  dronecan.sensors.rc.RCInput  status 5, quality 225, "
            "id 2, rcin [172 272 372 472 572 672 772 872 972 1072 1172 1272 1372 1472 1572 1672 "
            "1772 1872] us",
            "8 transfers in 18 CAN frames of 164 bytes, 0 other CAN frames, 0 error frames, 0 "
            "repeated frames, rejected: none; 0 is 1.000000 of the log",
            "1 request, 0 responses, 1 request without one",
            "anonymous: uavcan.protocol.dynamic_node_id.Allocation, 1 transfer",
            "node 10: uavcan.equipment.actuator.ArrayCommand, 1 transfer",
            "node 10: uavcan.equipment.esc.RawCommand, 1 transfer",
            "node 42: uavcan.protocol.NodeStatus, 1 transfer",
            "node 42: dronecan.sensors.rc.RCInput, 3 transfers",
            "node 127: uavcan.protocol.GetNodeInfo request, 1 transfer",
        }));
}

TEST(DecodeDroneCan, ChannelsAreAFrameAsOtherProtocolsDecodeItWithTheTransferBehindIt) {
    EXPECT_EQ(decoded(kExamples, DecodeFormat::json).lines().at(1),
              "{\"t_us\":20520,\"protocol\":\"dronecan\",\"channels\":[1500,1500,900,1500,1500,"
              "1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,null,null],\"frame_lost\":"
              "false,\"failsafe\":true,\"kind\":\"message\",\"type\":\"dronecan.sensors.rc.RCInput"
              "\",\"type_id\":1140,\"source\":42,\"destination\":null,\"priority\":8,"
              "\"transfer_id\":31,\"fd\":false,\"frames\":5,\"first_us\":20000,\"fields\":{"
              "\"status\":2,\"quality\":0,\"id\":0,\"rcin\":[1500,1500,900,1500,1500,1500,1500,"
              "1500,1500,1500,1500,1500,1500,1500,1500,1500]},\"units\":{\"rcin\":\"us\"},"
              "\"payload\":\"0200000dc5dc5843dc5dc5dc5dc5dc5dc5dc5dc5dc5dc5dc5dc5dc50\"}");
}

TEST(DecodeDroneCan, OtherTransfersHaveNoChannelsAndFieldsAsTheirTypesNestThem) {
    const auto found = objects(kExamples);
    ASSERT_EQ(found.size(), 9U);
    EXPECT_FALSE(found[2].contains("channels"));
    EXPECT_EQ(found[2]["fields"]["commands"][1],
              json::parse(R"({"actuator_id":2,"command_type":0,"command_value":-1.0})"));
    EXPECT_EQ(found[4]["fields"]["uptime_sec"], 1234);
    EXPECT_EQ(found[4]["units"], json::parse(R"({"uptime_sec":"s"})"));
    EXPECT_TRUE(found[5]["source"].is_null());
    EXPECT_EQ(found[5]["fields"]["unique_id"], "001122334455");
    EXPECT_EQ(found[6]["kind"], "request");
    EXPECT_EQ(found[6]["source"], 127);
    EXPECT_EQ(found[6]["destination"], 42);
    EXPECT_EQ(found[7]["fd"], true);
    EXPECT_EQ(found[8]["summary"]["frames"], 8);
}

TEST(DecodeDroneCan, WhatIsPrintedAsJsonIsReadByEncodeWhichTakesTheChannels) {
    std::size_t frames = 0;
    for (const std::string& line : decoded(kExamples, DecodeFormat::json).lines()) {
        const auto frame = parse_frame_json(line);
        ASSERT_TRUE(frame) << line;
        frames += frame->has_value() ? 1U : 0U;
    }
    EXPECT_EQ(frames, 3U);
}

TEST(DecodeDroneCan, ACsvHasALineForEachTransferAndTheSummaryIsAMessage) {
    const Outcome outcome = decoded(kExamples, DecodeFormat::csv);
    const Lines lines = outcome.lines();
    ASSERT_EQ(lines.size(), 9U);
    EXPECT_EQ(lines[0],
              "t_us,kind,type,type_id,source,destination,priority,transfer_id,frames,broken,"
              "response_us,payload,fields");
    EXPECT_EQ(lines[4],
              "40000,message,uavcan.equipment.esc.RawCommand,1030,10,,8,9,1,,,0003fdf0080010,"
              "\"cmd [0 8191 -8192 4096]\"");
    EXPECT_EQ(lines[6],
              "60000,message,uavcan.protocol.dynamic_node_id.Allocation,1,,,24,0,1,,,"
              "01001122334455,\"node_id 0, first_part_of_unique_id true, unique_id "
              "\"\"001122334455\"\"\"");
    EXPECT_EQ(lines[7], "70000,request,uavcan.protocol.GetNodeInfo,1,127,42,24,3,1,,,,\"\"");
    EXPECT_EQ(outcome.messages.substr(0, 12), "8 transfers ");
}

TEST(DecodeDroneCan, ABrokenTransferHasItsReasonAndWhatCameOfIt) {
    constexpr std::string_view kDamaged =
        "(1.000000) can0 0803F20A#61B7010000000282\n"
        "(1.000130) can0 0803F20A#0000BC0300003D22\n"
        "(1.000260) can0 0803F20A#0400003842\n";
    EXPECT_EQ(
        text_of(kDamaged),
        "         260       10    8   2  uavcan.equipment.actuator.ArrayCommand  broken: bad "
        "CRC: damaged, or the sender's type has another signature (3 frames received): 01 00 00 "
        "00 02 00 00 bc 03 00 00 3d 04 00 00 38");
    const auto found = objects(kDamaged);
    ASSERT_EQ(found.size(), 2U);
    EXPECT_EQ(found[0]["broken"], "bad_crc");
    EXPECT_EQ(found[0]["payload"], "01000000020000bc0300003d04000038");
    EXPECT_FALSE(found[0].contains("fields"));
    EXPECT_EQ(found[1]["summary"]["rejected"]["bad_crc"], 1);
    EXPECT_EQ(found[1]["summary"]["transfers"][0]["rejected"], json::parse(R"({"bad_crc":1})"));
}

TEST(DecodeDroneCan, ATypeThatIsNotKnownHasItsIdAndItsPayload) {
    EXPECT_EQ(text_of("(1.0) can0 1004D22A#010203C0\n"),
              "           0       42   16   0  message type 1234  unknown: 01 02 03");
    EXPECT_EQ(text_of("(1.0) can0 10C8AAFF#C0\n"),
              "           0  127->42   16   0  service 200 request  unknown: no payload");
    const auto found = objects("(1.0) can0 1004D22A#010203C0\n");
    EXPECT_TRUE(found.at(0)["type"].is_null());
    EXPECT_EQ(found.at(0)["type_id"], 1234);
    EXPECT_EQ(found.at(0)["crc_checked"], true);
}

TEST(DecodeDroneCan, AResponseSaysHowLongAfterItsRequestItCame) {
    constexpr std::string_view kCall =
        "(1.000000) can0 180BAAFF#0000C3\n"
        "(1.001250) can0 180B7FAA#00000000C3\n";
    EXPECT_EQ(decoded(kCall, DecodeFormat::text).lines().at(2).substr(0, 80),
              "        1250  42->127   24   3  uavcan.protocol.param.GetSet response after 1250");
    const auto found = objects(kCall);
    EXPECT_EQ(found.at(1)["response_us"], 1250);
    EXPECT_EQ(found.at(2)["summary"]["unanswered"], 0);
}

TEST(DecodeDroneCan, MeasurementsThatTheSenderDoesNotKnowAreNotAvailable) {
    // device.Temperature of device 7, NaN as libcanard and pydronecan send it.
    constexpr std::string_view kUnknown = "(1.0) can0 1804562A#0700FF7F00C0\n";
    EXPECT_NE(text_of(kUnknown).find("temperature not available,"), std::string::npos)
        << text_of(kUnknown);
    EXPECT_TRUE(objects(kUnknown).at(0)["fields"]["temperature"].is_null());
}

TEST(DecodeDroneCan, TextThatANodeSendsCannotReachTheTerminalAsControlCharacters) {
    // KeyValue 1.0 with the key "\x1B[2J" and 0xFF.
    const std::string text = text_of(
        "(1.0) can0 183FF22A#FFFF0000803F1B80\n"
        "(1.0) can0 183FF22A#5B324AFF60\n");
    EXPECT_EQ(text.find('\x1B'), std::string::npos);
    const std::string single = text_of("(1.0) can0 183FF22A#0000803F1BFFC0\n");
    EXPECT_NE(single.find("key \"\\u001b\\ufffd\""), std::string::npos) << single;
}

Lines words_of(const std::string& text) {
    std::istringstream stream(text);
    return {std::istream_iterator<std::string>(stream), {}};
}

TEST(DecodeDroneCan, OnATerminalLinesAreBrokenBetweenWordsWhereItsWidthEnds) {
    const Outcome wide = decoded(kExamples, DecodeFormat::text);
    for (const std::size_t columns : {1U, 20U, 50U, 80U, 120U}) {
        const Outcome narrow = decoded(kExamples, DecodeFormat::text, columns);
        EXPECT_EQ(words_of(narrow.results), words_of(wide.results)) << columns;
        for (const std::string& line : narrow.lines()) {
            if (line.find("0 other CAN frames") != std::string::npos) {
                break;
            }
            EXPECT_TRUE(columns < 50 || line.size() <= columns) << columns << ": " << line;
        }
    }
}

TEST(DecodeDroneCan, AStreamIsExplainedLineByLineAndLinesThatAreNoneAreReported) {
    std::vector<std::string> pieces{"(1.0) can0 1801552A#D2040000000000CC\n(1.1) can0 18015",
                                    "52A#D3040000000000CD\nrubbish\n"};
    std::size_t next = 0;
    std::string after_first;
    const Outcome outcome = outcome_of([&](std::ostringstream& results, std::ostream& messages) {
        TransferDecoding decoding(std::nullopt,
                                  {DecodeFormat::json, RecordingKind::candump, results, messages});
        const auto read = [&] {
            after_first = next == 1 ? results.str() : after_first;
            return next < pieces.size() ? pieces[next++] : std::string();
        };
        return decode_log({read, "standard input", ""}, decoding, results, messages);
    });
    EXPECT_NE(after_first.find("\"uptime_sec\":1234"), std::string::npos);
    EXPECT_EQ(outcome.lines().size(), 3U);
    EXPECT_EQ(outcome.status, kExitFailed);
    EXPECT_EQ(outcome.messages.substr(0, 17), "standard input:3:");
}

TEST(DecodeDroneCan, ALogIsOneOfDroneCanIfMostOfItsTransfersAreWholeAndKnown) {
    const auto is = [](std::string_view log) {
        const auto recording = parse_recording(log, "can.log", RecordingKind::candump);
        RecordingInMemory source(*recording);
        return is_dronecan(source);
    };
    EXPECT_TRUE(is(kExamples));
    EXPECT_FALSE(is(""));
    EXPECT_FALSE(is("(1.0) can0 123#0011\n"));
    EXPECT_FALSE(is("(1.0) can0 18DAF110#0011C0\n(1.1) can0 18DAF110#0011C1\n"));
}

}  // namespace
}  // namespace tribus::decode_dronecan_test
