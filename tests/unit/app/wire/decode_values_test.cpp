#include "app/wire/decode_values.h"

#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "app/cli/exit_status.h"
#include "tests/support/outcome.h"
#include "tests/support/shell.h"
#include "transports/registry/registry.h"

namespace tribus::decode_values_test {
namespace {

using test::Ended;
using test::Outcome;
using test::outcome_of;
using test::run_in_shell;

// Betaflight, telemetry_crsf_unittest.cc: 3.3 V, 29.6 A, 1234 mAh, 67 %; then a byte of noise, and
// a vertical speed of -2 m/s (docs/protocols/crsf.md, "Telemetry").
constexpr std::string_view kMessages =
    "1000 c8 0a 08 00 21 01 28 00 04 d2 43 b2\n"
    "50000 55 c8 04 07 ff 38 84\n";

Outcome decoded(std::string_view content, DecodeFormat format) {
    const auto recording = parse_recording(content, "wire.txt");
    EXPECT_TRUE(recording) << recording.error();
    const Protocol& protocol = *find_protocol("crsf-telemetry");
    return outcome_of([&](std::ostream& results, std::ostream& messages) {
        ValueDecoding decoding({.protocol = &protocol, .settings = {}, .line = {.baud = 1'000'000}},
                               {format, recording->kind, results, messages});
        RecordingInMemory source(*recording);
        return decode_recording(source, decoding, messages);
    });
}

TEST(DecodeValues, TextHasAMessageALine) {
    const Outcome outcome = decoded(kMessages, DecodeFormat::text);
    EXPECT_EQ(outcome.status, kExitFine);
    EXPECT_EQ(outcome.results,
              "        t_us  values\n"
              "        1110  battery.voltage 3.3 V, battery.current 29.6 A, battery.consumed 1234 "
              "mAh, battery.remaining 67 %\n"
              "       50060  vario -2 m/s\n"
              "2 frames in 19 bytes, 1 byte skipped, rejected: none\n");
}

TEST(DecodeValues, JsonHasTheNumbersByName) {
    const Outcome outcome = decoded(kMessages, DecodeFormat::json);
    EXPECT_EQ(outcome.results,
              R"({"t_us":1110,"protocol":"crsf-telemetry","values":{"battery.voltage":3.3,)"
              R"("battery.current":29.6,"battery.consumed":1234.0,"battery.remaining":67.0}})"
              "\n"
              R"({"t_us":50060,"protocol":"crsf-telemetry","values":{"vario":-2.0}})"
              "\n"
              R"({"summary":{"bytes":19,"frames":2,"rejected":{"checksum":0,"damaged":0},)"
              R"("skipped_bytes":1,"input":"timed"}})"
              "\n");
}

TEST(DecodeValues, CsvHasAValueALine) {
    const Outcome outcome = decoded(kMessages, DecodeFormat::csv);
    EXPECT_EQ(outcome.results,
              "t_us,value,number,unit\n"
              "1110,battery.voltage,3.3,V\n"
              "1110,battery.current,29.6,A\n"
              "1110,battery.consumed,1234,mAh\n"
              "1110,battery.remaining,67,%\n"
              "50060,vario,-2,m/s\n");
}

TEST(DecodeValues, ARecordingWithoutAMessageFails) {
    EXPECT_EQ(decoded("1000 c8 0a 08 00\n", DecodeFormat::text).status, kExitFailed);
}

TEST(DecodeValues, AreWhatTheCommandPrintsForAProtocolWithoutChannels) {
    const Ended ended = run_in_shell(
        "printf '\\310\\004\\007\\377\\070\\204' | \"$TRIBUS\" decode --protocol "
        "crsf-telemetry --format csv");
    EXPECT_EQ(ended.status, kExitFine);
    EXPECT_NE(ended.output.find(",vario,-2,m/s\n"), std::string::npos) << ended.output;
}

/// Lines for `encode` have channels.
TEST(DecodeValues, AreNotEncodedAndTheCommandSaysSo) {
    const Ended ended = run_in_shell(
        "echo '{\"channels\":[1500]}' | \"$TRIBUS\" encode --protocol crsf-telemetry --vario x "
        "2>&1");
    EXPECT_EQ(ended.status, kExitWrongUse);
    EXPECT_NE(ended.output.find("sends named values"), std::string::npos) << ended.output;
}

}  // namespace
}  // namespace tribus::decode_values_test
