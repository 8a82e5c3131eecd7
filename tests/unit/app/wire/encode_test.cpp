#include "app/wire/encode.h"

#include <sstream>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "app/cli/exit_status.h"
#include "tests/support/outcome.h"

namespace tribus::encode_test {
namespace {

using test::Outcome;
using test::outcome_of;

Outcome encoded(const std::string& lines, std::string_view protocol, EncodeFormat format,
                const GivenSettings& given = {}) {
    const auto uses = choose_protocols(protocol, SettingScope::output, given);
    EXPECT_TRUE(uses) << uses.error();
    std::istringstream input(lines);
    return outcome_of([&](std::ostream& results, std::ostream& messages) {
        return encode_lines(input, "frames.json", uses->front(), format, results, messages);
    });
}

constexpr std::string_view kCentred =
    "{\"channels\":[1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,"
    "1500]}\n";
// All channels at 992 (docs/protocols/sbus.md, "Vectors").
constexpr std::string_view kCentredSbus =
    "0f e0 03 1f f8 c0 07 3e f0 81 0f 7c e0 03 1f f8 c0 07 3e f0 81 0f 7c 00 00\n";

TEST(Encode, HexIsOneFrameALine) {
    const Outcome outcome =
        encoded(std::string(kCentred) + "\n" + std::string(kCentred) + "{\"summary\":{}}\n", "sbus",
                EncodeFormat::hex);
    EXPECT_EQ(outcome.status, kExitFine);
    EXPECT_EQ(outcome.results, std::string(kCentredSbus) + std::string(kCentredSbus));
    EXPECT_EQ(outcome.messages, "");
}

TEST(Encode, FlagsAndSwitchesReachTheWire) {
    const Outcome outcome = encoded(
        "{\"channels\":[null,null,null,null,null,null,null,null,null,null,null,null,null,null,"
        "null,null,2000,1000],\"frame_lost\":true,\"failsafe\":true}",
        "sbus", EncodeFormat::hex);
    EXPECT_EQ(outcome.results,
              "0f e0 03 1f f8 c0 07 3e f0 81 0f 7c e0 03 1f f8 c0 07 3e f0 81 0f 7c 0d 00\n");
}

TEST(Encode, SaysWhichMarksTheProtocolCannotCarry) {
    const std::string lines =
        "{\"channels\":[],\"frame_lost\":true}\n{\"channels\":[],\"frame_lost\":true}\n"
        "{\"channels\":[],\"failsafe\":true,\"frame_lost\":true}\n{\"channels\":[]}\n";
    const Outcome ibus = encoded(lines, "ibus", EncodeFormat::hex);
    EXPECT_EQ(ibus.status, kExitFine);
    EXPECT_EQ(ibus.messages,
              "tribus: 1 frame marked failsafe written without the mark, which ibus cannot carry\n"
              "tribus: 2 frames marked frame-lost written without the mark, which ibus cannot "
              "carry\n");
    EXPECT_EQ(encoded(lines, "sumd", EncodeFormat::hex).messages,
              "tribus: 2 frames marked frame-lost written without the mark, which sumd cannot "
              "carry\n");
    EXPECT_EQ(encoded(lines, "sbus", EncodeFormat::hex).messages, "");
}

TEST(Encode, BinaryIsTheBytesAlone) {
    const Outcome outcome = encoded(std::string(kCentred), "sbus", EncodeFormat::binary);
    EXPECT_EQ(outcome.results.size(), 25U);
    EXPECT_EQ(outcome.results.substr(0, 2), "\x0f\xe0");
}

TEST(Encode, TimedKeepsTimesAndSpacesFramesWithoutByTheDefaultPeriod) {
    const Outcome outcome = encoded(
        "{\"t_us\":1146,\"channels\":[]}\n{\"channels\":[]}\n{\"t_us\":20000,\"channels\":[]}\n",
        "sbus", EncodeFormat::timed);
    const std::string& text = outcome.results;
    EXPECT_EQ(text.substr(0, text.find('\n') + 1), "# t_us  bytes\n");
    EXPECT_NE(text.find("\n1146 0f "), std::string::npos);
    EXPECT_NE(text.find("\n15146 0f "), std::string::npos);
    EXPECT_NE(text.find("\n20000 0f "), std::string::npos);
}

TEST(Encode, VcdStartsWithItsHeadEvenWithoutFrames) {
    const Outcome outcome = encoded("", "sbus", EncodeFormat::vcd);
    EXPECT_EQ(outcome.status, kExitFine);
    EXPECT_EQ(outcome.results.substr(0, 10), "$timescale");
}

TEST(Encode, VcdSaysWhenFramesDoNotFitOnTheWire) {
    const Outcome outcome =
        encoded("{\"t_us\":0,\"channels\":[]}\n{\"t_us\":1000,\"channels\":[]}\n", "sbus",
                EncodeFormat::vcd);
    EXPECT_EQ(outcome.messages,
              "tribus: 1 frame delayed, because the frame before was still on the wire\n");
}

TEST(Encode, ReportsEveryLineThatCannotBeUsedAndEncodesTheRest) {
    const Outcome outcome =
        encoded("{\"channels\":[9000]}\n" + std::string(kCentred) + "nonsense\n", "sbus",
                EncodeFormat::hex);
    EXPECT_EQ(outcome.status, kExitFailed);
    EXPECT_EQ(outcome.results, kCentredSbus);
    EXPECT_EQ(outcome.messages,
              "frames.json:1:1: channel 1 is 9000; allowed: -4096 to 4095.875 us, or null\n"
              "frames.json:3:2: not JSON; a line must be one object, as decode prints it\n");
}

TEST(Encode, RefusesTimesThatGoBack) {
    const Outcome outcome = encoded("{\"t_us\":10,\"channels\":[]}\n{\"t_us\":9,\"channels\":[]}\n",
                                    "sbus", EncodeFormat::hex);
    EXPECT_EQ(outcome.status, kExitFailed);
    EXPECT_EQ(outcome.messages,
              "frames.json:2:1: t_us is 9, less than the 10 of the frame before; times must not go "
              "back\n");
}

TEST(Encode, StopsAtALineThatNeverEnds) {
    const Outcome outcome = encoded(std::string(1 << 20, 'x'), "sbus", EncodeFormat::hex);
    EXPECT_EQ(outcome.status, kExitFailed);
    EXPECT_EQ(outcome.results, "");
}

TEST(Encode, IbusChannelsSettingChoosesTheFrame) {
    const std::string frame =
        "{\"channels\":[1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,"
        "1500,1500,1500,1500]}\n";
    EXPECT_EQ(encoded(frame, "ibus", EncodeFormat::hex, {{"channels", "14"}}).results.substr(0, 12),
              "20 40 dc 05 ");
    EXPECT_EQ(encoded(frame, "ibus", EncodeFormat::hex, {{"channels", "18"}}).results.substr(0, 12),
              "20 40 dc c5 ");
}

}  // namespace
}  // namespace tribus::encode_test
