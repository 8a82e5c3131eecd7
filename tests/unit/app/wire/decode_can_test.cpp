#include "app/wire/decode_frames.h"

#include <array>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "app/cli/exit_status.h"
#include "tests/support/outcome.h"
#include "tests/support/tiny_can.h"
#include "transports/recordings/recording.h"

namespace tribus::decode_can_test {
namespace {

using test::kOtherTinyCan;
using test::kTinyCan;
using test::Outcome;
using test::outcome_of;
using test::use_of;

// 0x05DC is 1500, 0x03E8 is 1000.
constexpr std::string_view kLog =
    "(1436509052.249713) can0 123#05DC\n"
    "(1436509052.250000) can0 456#0011223344\n"
    "(1436509052.269713) can0 123#03E8\n"
    "(1436509052.270000) can0 123#01\n"
    "(1436509052.280000) can0 20000040#0000000000000000\n";
constexpr std::string_view kTwoInterfaces =
    "(1.000000) can0 123#05DC\n"
    "(1.010000) can1 123#03E8\n";
const std::vector<std::string> kTwoNames{"can0", "can1"};

Recording recording_of(std::string_view log) {
    const auto recording = parse_recording(log, "can.log");
    EXPECT_TRUE(recording) << recording.error();
    return recording.value_or(Recording{});
}

Outcome decoded(std::string_view log, const std::vector<ProtocolUse>& uses, DecodeFormat format) {
    return outcome_of([&](std::ostream& results, std::ostream& messages) {
        const DecodeOutput output{format, RecordingKind::candump, results, messages};
        const Recording recording = recording_of(log);
        RecordingInMemory source(recording);
        return decode_frames(source, uses, output);
    });
}

/// Passes the log in these pieces. `after` sees the results after each piece.
Outcome streamed(const std::vector<std::string>& pieces, const std::string& interface = "",
                 std::vector<std::string>* after = nullptr) {
    return outcome_of([&](std::ostringstream& results, std::ostream& messages) {
        const DecodeOutput output{DecodeFormat::csv, RecordingKind::candump, results, messages};
        std::size_t next = 0;
        const auto read = [&] {
            if (next > 0 && after != nullptr) {
                after->push_back(results.str());
            }
            return next < pieces.size() ? pieces[next++] : std::string();
        };
        const CanLogSource source{.read = read, .name = "standard input", .interface = interface};
        FrameDecoding decoding(use_of(kTinyCan), output);
        return decode_log(source, decoding, results, messages);
    });
}

std::string error_of(const tl::expected<void, std::string>& checked) {
    EXPECT_FALSE(checked);
    return checked ? std::string() : checked.error();
}

TEST(DecodeCan, JsonCountsTheFramesOfTheLogFromItsFirstLine) {
    const Outcome outcome = decoded(kLog, {use_of(kTinyCan)}, DecodeFormat::json);
    EXPECT_EQ(outcome.status, kExitFine);
    EXPECT_EQ(outcome.results,
              "{\"t_us\":0,\"protocol\":\"tiny\",\"channels\":[1500,null,null,null,null,null,null,"
              "null,null,null,null,null,null,null,null,null,null,null],\"frame_lost\":false,"
              "\"failsafe\":false}\n"
              "{\"t_us\":20000,\"protocol\":\"tiny\",\"channels\":[1000,null,null,null,null,null,"
              "null,null,null,null,null,null,null,null,null,null,null,null],\"frame_lost\":false,"
              "\"failsafe\":false}\n"
              "{\"summary\":{\"bytes\":10,\"can_frames\":4,\"frames\":2,\"rejected\":{\"length\":"
              "1},\"other_can_frames\":1,\"error_frames\":1,\"log_start_us\":1436509052249713,"
              "\"input\":\"candump\"}}\n");
}

TEST(DecodeCan, TextEndsWithASummaryThatShowsTheTimeOfTheLog) {
    const Outcome outcome = decoded(kLog, {use_of(kTinyCan)}, DecodeFormat::text);
    ASSERT_EQ(outcome.lines().size(), 4U);
    EXPECT_EQ(outcome.lines()[2].substr(0, 26), "       20000 tiny     1000");
    EXPECT_EQ(outcome.lines()[3],
              "2 frames in 4 CAN frames of 10 bytes, 1 other CAN frame, 1 error frame, rejected: "
              "1 length; 0 is 1436509052.249713 of the log");
}

TEST(DecodeCan, CsvKeepsTheSummaryOut) {
    const Outcome outcome = decoded(kLog, {use_of(kTinyCan)}, DecodeFormat::csv);
    ASSERT_EQ(outcome.lines().size(), 3U);
    EXPECT_EQ(outcome.lines()[2], "20000,1000,,,,,,,,,,,,,,,,,,0,0");
    EXPECT_EQ(outcome.messages.substr(0, 28), "2 frames in 4 CAN frames of ");
}

TEST(DecodeCan, ProtocolThatFindsTheMostReadsTheLog) {
    const Outcome outcome =
        decoded("(1.0) can0 123#05DC\n(1.0) can0 124#05DC\n(1.0) can0 124#05DC\n",
                {use_of(kTinyCan), use_of(kOtherTinyCan)}, DecodeFormat::text);
    EXPECT_EQ(outcome.status, kExitFine);
    ASSERT_EQ(outcome.lines().size(), 4U);
    EXPECT_NE(outcome.lines()[1].find("other"), std::string::npos);
}

TEST(DecodeCan, LogOfNoneOfSeveralProtocolsIsAFailure) {
    const Outcome outcome = decoded("(1.0) can0 456#05DC\n",
                                    {use_of(kTinyCan), use_of(kOtherTinyCan)}, DecodeFormat::json);
    EXPECT_EQ(outcome.status, kExitFailed);
    EXPECT_EQ(outcome.messages, "tribus: no snapshot of tiny or other in 1 CAN frame\n");
    ASSERT_EQ(outcome.lines().size(), 1U);
    EXPECT_EQ(outcome.lines()[0].substr(0, 12), "{\"summary\":{");
}

TEST(DecodeCan, SeveralInterfacesAreListedWhereNoneWasNamed) {
    EXPECT_EQ(error_of(check_interface(kTwoNames, "can.log", "")),
              "can.log: frames of several interfaces, \"can0\", \"can1\"; select one with "
              "--interface NAME");
}

TEST(DecodeCan, InterfaceOfTheLogMayBeNamed) {
    EXPECT_TRUE(check_interface(kTwoNames, "can.log", "can1"));
}

TEST(DecodeCan, InterfaceThatIsNotInTheLogIsRefused) {
    EXPECT_EQ(error_of(check_interface(kTwoNames, "can.log", "can2")),
              "can.log: no frame of the interface \"can2\"; did you mean \"can0\"? Allowed: "
              "\"can0\", \"can1\"");
}

TEST(DecodeCan, EmptyLogHasEveryInterface) {
    EXPECT_TRUE(check_interface({}, "can.log", "can2"));
}

TEST(DecodeCanStream, FrameIsPrintedAsSoonAsItsLineEnds) {
    std::vector<std::string> after;
    const Outcome outcome =
        streamed({"(1.000000) can0 123#05DC\n(1.02", "0000) can0 123#03E8", "\n"}, "", &after);
    ASSERT_EQ(after.size(), 3U);
    const auto ends_with_1500 = [](const std::string& text) {
        return text.ends_with("\n0,1500,,,,,,,,,,,,,,,,,,0,0\n");
    };
    EXPECT_TRUE(ends_with_1500(after[0])) << after[0];
    EXPECT_TRUE(ends_with_1500(after[1])) << after[1];
    EXPECT_TRUE(after[2].ends_with("\n20000,1000,,,,,,,,,,,,,,,,,,0,0\n")) << after[2];
    EXPECT_EQ(outcome.status, kExitFine);
}

TEST(DecodeCanStream, LastLineNeedsNoEnd) {
    EXPECT_EQ(streamed({"(1.000000) can0 123#05DC"}).lines().size(), 2U);
}

TEST(DecodeCanStream, LineThatCannotBeUsedIsReportedAndLeftOut) {
    const Outcome outcome =
        streamed({"(1.000000) can0 123#05DC\n(1.000000) can0 123#05D\n(2.0) can0 123#03E8\n"});
    EXPECT_EQ(outcome.status, kExitFailed);
    EXPECT_EQ(outcome.lines().size(), 3U);
    EXPECT_EQ(outcome.messages.substr(0, outcome.messages.find('\n')),
              "standard input:2:23: \"D\" is not a byte; a byte is two hex digits");
}

TEST(DecodeCanStream, StopsWhereTooMuchCannotBeUsed) {
    std::string rubbish;
    for (int line = 0; line < 100; ++line) {
        rubbish += "( \n";
    }
    const Outcome outcome = streamed({rubbish});
    EXPECT_EQ(outcome.status, kExitFailed);
    EXPECT_NE(outcome.messages.find("standard input:20:1:"), std::string::npos);
    EXPECT_EQ(outcome.messages.find("standard input:21:1:"), std::string::npos);
}

TEST(DecodeCanStream, StopsAtALineWithoutEnd) {
    const Outcome outcome = streamed({"(1.000000) can0 123#", std::string(5000, '1'), "\n"});
    EXPECT_EQ(outcome.status, kExitFailed);
    EXPECT_EQ(outcome.messages.substr(0, 55),
              "tribus: stopped, a line of more than 4096 characters is");
}

TEST(DecodeCanStream, StopsAtASecondInterfaceThatNobodyNamed) {
    const Outcome outcome = streamed({std::string(kTwoInterfaces)});
    EXPECT_EQ(outcome.status, kExitFailed);
    EXPECT_EQ(outcome.messages.substr(0, outcome.messages.find('\n')),
              "tribus: stopped, standard input: frames of several interfaces, \"can0\", \"can1\"; "
              "select one with --interface NAME");
    EXPECT_EQ(outcome.lines().size(), 2U);
}

TEST(DecodeCanStream, InterfaceOfTheLogMayBeNamed) {
    const Outcome outcome = streamed({std::string(kTwoInterfaces)}, "can1");
    EXPECT_EQ(outcome.status, kExitFine);
    ASSERT_EQ(outcome.lines().size(), 2U);
    EXPECT_EQ(outcome.lines()[1].substr(0, 11), "10000,1000,");
}

TEST(DecodeCanStream, InterfaceThatNeverCameIsAFailure) {
    const Outcome outcome = streamed({std::string(kTwoInterfaces)}, "can2");
    EXPECT_EQ(outcome.status, kExitFailed);
    EXPECT_NE(outcome.messages.find("no frame of the interface \"can2\""), std::string::npos);
}

}  // namespace
}  // namespace tribus::decode_can_test
