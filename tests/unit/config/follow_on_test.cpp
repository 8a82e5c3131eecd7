#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

namespace tribus::test::follow_on_test {
namespace {

using Lines = std::vector<std::string>;

/// Returns only the places: `line:column`.
Lines places(std::string_view text) {
    Lines result;
    for (const std::string& line : mistakes_in(text)) {
        const std::string rest = line.substr(line.find(':') + 1);
        result.push_back(rest.substr(0, rest.find(": ")));
    }
    return result;
}

TEST(FollowOn, AnEmptyFileHasNoPipeline) {
    EXPECT_EQ(mistakes_in(""),
              Lines{"t.toml:1:1: there is no pipeline, so nothing would happen; a pipeline "
                    "connects inputs to outputs: [pipeline.main] with \"from\" and \"to\""});
}

TEST(FollowOn, WithoutAnyPipelineInputsAndOutputsAreNotCalledUnused) {
    const std::string text = main_job_with(0, "");
    EXPECT_EQ(places(text.substr(0, text.find("[pipeline.main]"))), Lines{"1:1"});
}

/// A sensor bus needs no pipeline, so the input is what is wrong.
TEST(FollowOn, BesideWhatNeedsNoPipelineAnUnusedInputIsNamed) {
    EXPECT_EQ(mistakes_in("[input.rx]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n"
                          "[sensor_bus.bus]\ndevice = \"/dev/ttyB\"\nrole = \"receiver\"\n"),
              Lines{"t.toml:1:8: input \"rx\" feeds no pipeline, so it would have no effect; name "
                    "it in the \"from\" of a pipeline, or leave it out"});
}

TEST(FollowOn, TwoInputsMayNotShareADeviceAndTheMessageNamesBothPlaces) {
    EXPECT_EQ(mistakes_in(R"([input.a]
protocol = "ibus"
device = "/dev/ttyA"
[input.b]
protocol = "ibus"
device = "/dev/ttyA"
[output.servos]
protocol = "sbus"
device = "/dev/ttyB"
[pipeline.main]
from = ["a", "b"]
to = "servos")"),
              Lines{"t.toml:6:10: device \"/dev/ttyA\" is already used by [input.a] in line 3; one "
                    "device serves at most one input and one output"});
}

TEST(FollowOn, AnSpiPortIsOneDeviceAlsoWhereItIsUsedInTwoWays) {
    EXPECT_EQ(
        mistakes_in(R"([input.receiver]
protocol = "ibus"
device = "/dev/ttyA"
[output.trainer]
protocol = "ppm"
line = "/dev/spidev0.0"
[output.servos]
protocol = "sbus"
spi = "/dev/spidev0.0"
[pipeline.main]
from = "receiver"
to = ["servos", "trainer"])"),
        Lines{"t.toml:9:7: spi \"/dev/spidev0.0\" is already used by [output.trainer] in line "
              "6; one spi serves one input or one output"});
}

TEST(FollowOn, AnSpiPortDoesNotServeAnInputAndAnOutput) {
    EXPECT_EQ(
        mistakes_in(R"([input.receiver]
protocol = "sbus"
spi = "/dev/spidev0.0"
[output.servos]
protocol = "sbus"
spi = "/dev/spidev0.0"
[pipeline.main]
from = "receiver"
to = "servos")"),
        Lines{"t.toml:6:7: spi \"/dev/spidev0.0\" is already used by [input.receiver] in line 3; "
              "one spi serves one input or one output: a transfer that draws a frame cannot wait "
              "for one that listens"});
}

TEST(FollowOn, AMisspeltInputDoesNotMakeTheOneThatWasMeantUnused) {
    EXPECT_EQ(places(main_job_with(8, "from = \"reciever\"")), Lines{"8:8"});
}

TEST(FollowOn, AnUnknownNameThatIsLikeNoneLeavesOpenWhatIsUsed) {
    EXPECT_EQ(places(main_job_with(8, "from = \"x\"")), Lines{"8:8"});
}

TEST(FollowOn, TheValueOfAMisspeltKeyIsJudgedInTheSameRun) {
    EXPECT_EQ(places(main_job_with(3, "devcie = 3")), (Lines{"3:1", "3:10"}));
}

TEST(FollowOn, TheContentOfAMisspeltTableIsJudgedInTheSameRun) {
    EXPECT_EQ(places(main_job_with(7, "[pipelin.main]\nchannels = 5")), (Lines{"7:2", "8:12"}));
}

TEST(FollowOn, AnInputWithoutANameDoesNotMakeItsUserWrong) {
    EXPECT_EQ(places(main_job_with(1, "[input]")), (Lines{"2:1", "3:1"}));
}

TEST(FollowOn, AWrongTimeoutIsNotComparedWithAPeriod) {
    EXPECT_EQ(places(main_job_with(3, "device = \"/dev/ttyA\"\ntimeout = \"1ms\"")), Lines{"4:11"});
}

TEST(FollowOn, ALineThatIsNotTomlDoesNotMakeItsKeyMissing) {
    EXPECT_EQ(places(main_job_with(2, "protocol \"ibus\"")), Lines{"2:10"});
}

TEST(FollowOn, ABrokenHeaderDoesNotMakeItsTableMissing) {
    EXPECT_EQ(places(main_job_with(1, "[input.receiver]]")), Lines{"1:17"});
    EXPECT_EQ(places(main_job_with(7, "[pipeline.main]]")), Lines{"7:16"});
}

TEST(FollowOn, MistakesBehindOneThatIsNotTomlAreReportedToo) {
    EXPECT_EQ(places(R"([input.receiver]
protocol = ibus
device = "/dev/ttyA
timeout = 100ms
baudd = 9600
[output.servos
protocol = "sbus"
device = "/dev/ttyB"
period == "14ms"
force = 1
[pipeline.main]
from = ["receiver"
to = "servo"
)"),
              (Lines{"2:13", "3:20", "4:14", "5:1", "6:15", "9:9", "10:9", "12:19", "13:6"}));
}

TEST(FollowOn, ALongListThatIsNeverClosedCostsOneMistake) {
    EXPECT_EQ(places(main_job_with(8, "from = [\n  \"receiver\",\n")), Lines{"9:14"});
}

}  // namespace
}  // namespace tribus::test::follow_on_test
