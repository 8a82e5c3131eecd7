#include "app/wire/decode_sensor.h"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/exit_status.h"
#include "app/wire/sensors/sensor_frame_finder.h"
#include "tests/support/outcome.h"
#include "tests/support/shell.h"

namespace tribus::decode_sensor_test {
namespace {

using nlohmann::json;
using test::Ended;
using test::Outcome;
using test::outcome_of;
using test::run_in_shell;

// A receiver finds a voltmeter at address 1, probes address 2, gets no value and then gets one.
// Requests, times and the value FFFE are those of an FS-iA6B with a CVT01 (docs/protocols/ibus.md,
// "Sensor bus: timing").
constexpr std::string_view kStart =
    "# t_us  bytes\n"
    "1000 04 f0 0b ff\n"
    "8700 04 81 7a ff\n"
    "9704 04 81 7a ff\n"
    "16401 04 91 6a ff\n"
    "17405 06 91 03 02 63 ff\n"
    "24102 04 82 79 ff\n"
    "31803 04 a1 5a ff\n"
    "39504 04 a1 5a ff\n"
    "40508 06 a1 fe ff 5b fd\n";

Outcome decoded(std::string_view content, DecodeFormat format,
                SensorDialect dialect = SensorDialect::flysky) {
    const auto recording = parse_recording(content, "wire.txt");
    EXPECT_TRUE(recording) << recording.error();
    const SensorTypes types(dialect);
    return outcome_of([&](std::ostream& results, std::ostream& messages) {
        SensorDecoding decoding(types, {format, recording->kind, results, messages});
        RecordingInMemory source(*recording);
        return decode_recording(source, decoding, messages);
    });
}

TEST(DecodeSensor, TextTellsWhatWasAskedAndWhatCameOfIt) {
    const Outcome outcome = decoded(kStart, DecodeFormat::text);
    EXPECT_EQ(outcome.status, kExitFine);
    EXPECT_EQ(
        outcome.results,
        "        t_us address asked    after_us  answer\n"
        "        1000       - power_up        -  power-up frame\n"
        "        8700       1 discover      631  here\n"
        "       16401       1 type          631  external_voltage (0x03), 2 bytes\n"
        "       24102       2 discover        -  no answer: address is free\n"
        "       31803       1 value           -  no answer, asked again\n"
        "       39504       1 value         631  external_voltage -0.02 V\n"
        "9 frames in 40 bytes, 0 bytes skipped, rejected: none\n"
        "4 requests, 3 replies, 1 misses (1 asked again at once), 1 probes of free addresses\n"
        "2 discover, 1 type, 2 value, 1 power-up frames, 0 servo frames, 0 echoes, 0 answers "
        "without a request\n"
        "address 1: external_voltage, 4 requests, 3 replies, 1 misses, answers after 631 to 631 "
        "us, median 631 us\n"
        "address 2: free, 1 probes\n");
}

TEST(DecodeSensor, JsonIsOneObjectALine) {
    const std::vector<std::string> lines = decoded(kStart, DecodeFormat::json).lines();
    ASSERT_EQ(lines.size(), 7U);
    EXPECT_EQ(lines[0], R"({"t_us":1000,"protocol":"ibus-sensor","address":0,"asked":"power_up",)"
                        R"("answer":"none"})");
    EXPECT_EQ(lines[2],
              R"({"t_us":16401,"protocol":"ibus-sensor","address":1,"asked":"type",)"
              R"("answer":"reply","response_us":631,"type":"external_voltage","type_id":3,)"
              R"("data":[3,2]})");
    EXPECT_EQ(lines[4],
              R"({"t_us":31803,"protocol":"ibus-sensor","address":1,"asked":"value",)"
              R"("answer":"miss","asked_again":true,"type":"external_voltage","type_id":3})");
    EXPECT_EQ(lines[5],
              R"({"t_us":39504,"protocol":"ibus-sensor","address":1,"asked":"value",)"
              R"("answer":"reply","response_us":631,"type":"external_voltage","type_id":3,)"
              R"("data":[254,255],"raw":65534,)"
              R"("values":[{"name":"voltage","number":-0.02,"unit":"V"}]})");
}

TEST(DecodeSensor, JsonEndsWithASummary) {
    const json summary = json::parse(decoded(kStart, DecodeFormat::json).lines().back())["summary"];
    EXPECT_EQ(summary["bytes"], 40);
    EXPECT_EQ(summary["frames"], 9);
    EXPECT_EQ(summary["requests"], 4);
    EXPECT_EQ(summary["replies"], 3);
    EXPECT_EQ(summary["misses"], 1);
    EXPECT_EQ(summary["probes"], 1);
    EXPECT_EQ(summary["power_up"], 1);
    EXPECT_EQ(summary["rejected"]["checksum"], 0);
    EXPECT_EQ(summary["input"], "timed");
    ASSERT_EQ(summary["addresses"].size(), 2U);
    EXPECT_EQ(summary["addresses"][0]["type"], "external_voltage");
    EXPECT_EQ(summary["addresses"][0]["response_us"]["median"], 631);
}

TEST(DecodeSensor, CsvHasItsSummaryAside) {
    const Outcome outcome = decoded(kStart, DecodeFormat::csv);
    const std::vector<std::string> lines = outcome.lines();
    ASSERT_EQ(lines.size(), 7U);
    EXPECT_EQ(lines[0], "t_us,address,asked,answer,response_us,type,data,raw,number,unit");
    EXPECT_EQ(lines[6], "39504,1,value,reply,631,external_voltage,fe ff,65534,-0.02,V");
    EXPECT_NE(outcome.messages.find("4 requests"), std::string::npos);
}

TEST(DecodeSensor, WithoutATypeAValueIsAsItWasSent) {
    const Outcome outcome = decoded("04 a2 59 ff 06 a2 fe ff 5a fd\n", DecodeFormat::text);
    EXPECT_NE(outcome.results.find("raw 65534 (fe ff), type not seen\n"), std::string::npos)
        << outcome.results;
}

TEST(DecodeSensor, ATypeThatNobodyKnowsIsItsNumber) {
    const Outcome outcome = decoded(
        "04 91 6a ff 06 91 42 02 24 ff\n04 a1 5a ff 06 a1 00 00 58 ff\n", DecodeFormat::text);
    EXPECT_NE(outcome.results.find("  0x42 (0x42), 2 bytes\n"), std::string::npos);
    EXPECT_NE(outcome.results.find("raw 0 (00 00), unknown type 0x42\n"), std::string::npos)
        << outcome.results;
}

// 0B has the fix and the satellites, which INAV swaps.
TEST(DecodeSensor, ADialectReadsTheDisputedTypesItsWay) {
    constexpr std::string_view kGps =
        "04 91 6a ff 06 91 0b 02 5b ff\n04 a1 5a ff 06 a1 03 09 4c ff\n";
    EXPECT_NE(decoded(kGps, DecodeFormat::text).results.find("gps_status fix 3, satellites 9\n"),
              std::string::npos);
    EXPECT_NE(decoded(kGps, DecodeFormat::text, SensorDialect::inav)
                  .results.find("gps_status satellites 3, fix 9\n"),
              std::string::npos);
}

TEST(DecodeSensor, ANumberThatASensorDoesNotHaveIsNotAvailable) {
    const Outcome outcome = decoded(
        "04 91 6a ff 06 91 03 02 63 ff\n04 a1 5a ff 06 a1 00 80 d8 fe\n", DecodeFormat::json);
    EXPECT_NE(outcome.results.find(R"("number":null)"), std::string::npos) << outcome.results;
}

TEST(DecodeSensor, BytesWithoutAFrameAreAFailure) {
    const Outcome outcome = decoded("01 02 03\n", DecodeFormat::json);
    EXPECT_EQ(outcome.status, kExitFailed);
    EXPECT_EQ(outcome.messages,
              "tribus: no frame of ibus-sensor in 3 bytes; no other protocol finds any\n");
}

TEST(DecodeSensor, AnEmptyFileIsFine) {
    EXPECT_EQ(decoded("", DecodeFormat::json).status, kExitFine);
}

TEST(DecodeSensor, ADamagedByteCostsItsFrame) {
    Recording recording;
    recording.bursts.push_back(
        {.start = std::nullopt,
         .bytes = {0x04, 0xA1, 0x5A, 0xFF, 0x06, 0xA1, 0x00, 0x00, 0x58, 0xFF},
         .damaged = std::vector<bool>(10)});
    recording.bursts.front().damaged[6] = true;
    unsigned frames = 0;
    SensorFrameFinder finder([&](const ReceivedSensorFrame&) { ++frames; });
    finder.feed_burst(0, recording.bursts.front());
    EXPECT_EQ(frames, 1U);
    EXPECT_EQ(finder.tally().frames.skipped_bytes, 6U);
}

TEST(DecodeSensor, IsTheSensorBusWhereHalfOfTheBytesAreItsFrames) {
    const auto is = [](std::string_view content) {
        const auto recording = parse_recording(content, "wire.txt");
        RecordingInMemory source(*recording);
        return is_sensor_bus(source);
    };
    EXPECT_TRUE(is(kStart));
    EXPECT_TRUE(is("04 a1 5a ff 00 01 02 03\n"));
    EXPECT_FALSE(is("04 a1 5a ff 00 01 02 03 05\n"));
    EXPECT_FALSE(is(""));
}

// The value of a genuine sensor (docs/protocols/ibus.md, "Vectors").
constexpr const char* kHex = "echo '04 a2 59 ff 06 a2 fe ff 5a fd' | \"$TRIBUS\" decode ";

TEST(DecodeSensorProgram, AutoKnowsTheSensorBus) {
    const Ended result = run_in_shell(std::string(kHex) + "--format csv");
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.output.find(",2,value,reply,,,fe ff,65534,,\n"), std::string::npos)
        << result.output;
}

TEST(DecodeSensorProgram, AMisspeltProtocolIsToldOfTheSensorBusToo) {
    const Ended result = run_in_shell(std::string(kHex) + "--protocol ibus-senso");
    EXPECT_EQ(result.status, 2);
    EXPECT_NE(result.output.find(", ibus-sensor\n"), std::string::npos) << result.output;
}

TEST(DecodeSensorProgram, RawBytesOfAPipeAreRead) {
    const Ended result = run_in_shell(
        "printf '\\004\\242\\131\\377' | \"$TRIBUS\" decode --protocol ibus-sensor --format json");
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.output.find("\"requests\":1"), std::string::npos) << result.output;
}

TEST(DecodeSensorProgram, AStreamWithoutAFrameNamesTheProtocolThatFindsSome) {
    // An i.Bus frame in raw bytes: 14 channels at 1500 us.
    std::string frame = "\\040\\100";
    for (int slot = 0; slot < 14; ++slot) {
        frame += "\\334\\005";
    }
    const Ended result = run_in_shell("printf '" + frame +
                                      "\\121\\363' | \"$TRIBUS\" decode --protocol ibus-sensor");
    EXPECT_EQ(result.status, 1);
    EXPECT_NE(result.output.find("tribus: no frame of ibus-sensor in 32 bytes; protocols that find "
                                 "frames: ibus (1 frame)\n"),
              std::string::npos)
        << result.output;
}

TEST(DecodeSensorProgram, NoChannelsAreEncodedForTheBus) {
    const Ended result = run_in_shell("echo | \"$TRIBUS\" encode --protocol ibus-sensor");
    EXPECT_EQ(result.status, 2);
    EXPECT_NE(result.output.find("the sensor bus has no channels"), std::string::npos);
}

TEST(DecodeSensorProgram, WhatDoesNotGoTogetherEndsWithTwo) {
    EXPECT_EQ(run_in_shell(std::string(kHex) + "--dialect inav").status, 2);
    EXPECT_EQ(run_in_shell(std::string(kHex) + "--protocol ibus-sensor --dialect x").status, 2);
    EXPECT_EQ(run_in_shell(std::string(kHex) + "--protocol ibus-sensor --baud 9600").status, 2);
    EXPECT_EQ(run_in_shell(std::string(kHex) + "--protocol ibus-sensor --interface can0").status,
              2);
    EXPECT_EQ(
        run_in_shell("echo '(1.0) can0 123#11' | \"$TRIBUS\" decode --protocol ibus-sensor").status,
        2);
    EXPECT_EQ(run_in_shell(std::string(kHex) + "--protocol ibus-sensor --dialect inav").status, 0);
}

}  // namespace
}  // namespace tribus::decode_sensor_test
