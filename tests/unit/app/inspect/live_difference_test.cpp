#include "app/inspect/live_difference.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "tests/unit/config/main_job.h"

namespace tribus::test::live_difference_test {
namespace {

const std::string kJob = main_job_with(0, "");

/// Returns a daemon's status with the receiver's first channels, or `null` for none.
nlohmann::json status_with(const std::string& state, const std::string& channels,
                           int interval_us = 7000) {
    return nlohmann::json::parse(R"({"inputs":[{"name":"receiver","state":")" + state +
                                 R"(","interval_us":)" + std::to_string(interval_us) +
                                 R"(,"channels":[)" + channels + "]}]}");
}

std::string difference(std::string_view before, std::string_view after,
                       const nlohmann::json& status) {
    const Configuration running = loaded(before);
    return live_difference(running, loaded(after), live_inputs(running, status));
}

const nlohmann::json kSticks = status_with("good", "1100,1500,988,1500,1500,1500");

TEST(LiveDifference, NamesTheChannelsThatWouldJumpAndBothValues) {
    EXPECT_EQ(difference(kJob,
                         kJob + "[pipeline.main.channels]\n"
                                "1 = { from = 1, reverse = true }\n"
                                "5 = { fixed = 1200 }\n",
                         kSticks),
              "with the inputs as they are now (receiver good):\n"
              "output servos:\n"
              "  channel 1: 1100 us now, then 1900 us\n"
              "  channel 5: 1500 us now, then 1200 us\n");
}

TEST(LiveDifference, SaysSoWhereNoOutputChanges) {
    EXPECT_EQ(
        difference(kJob, main_job_with(6, "device = \"/dev/ttyB\"\nperiod = \"9ms\""), kSticks),
        "with the inputs as they are now (receiver good):\n"
        "no output changes\n");
}

/// From 1500 to 1000 us at 20 us a second takes 25 s.
TEST(LiveDifference, WaitsUntilSlowChannelsHaveArrived) {
    EXPECT_EQ(
        difference(kJob, kJob + "[pipeline.main.channels]\n1 = { from = 2, slew = \"20us/s\" }\n",
                   kSticks),
        "with the inputs as they are now (receiver good):\n"
        "output servos:\n"
        "  channel 1: 1100 us now, then 1500 us\n");
}

/// The number of received channels tells i.Bus of 14 channels from i.Bus of 18.
TEST(LiveDifference, RepeatsAllEighteenChannelsOfAReceiverThatHasThem) {
    const nlohmann::json eighteen = status_with(
        "good",
        "1500,1500,988,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1650,"
        "1500,1700");
    EXPECT_EQ(difference(kJob, kJob + "[pipeline.main.channels]\n1 = 16\n2 = 18\n", eighteen),
              "with the inputs as they are now (receiver good):\n"
              "output servos:\n"
              "  channel 1: 1500 us now, then 1650 us\n"
              "  channel 2: 1500 us now, then 1700 us\n");
}

/// The receiver still sends the same bytes.
TEST(LiveDifference, ReadsTheSameBytesInTheNewScaleOfAnInput) {
    const std::string sbus = "[input.receiver]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n";
    const std::string rest =
        "[output.servos]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyB\"\n"
        "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n";
    const std::string text =
        difference(sbus + rest, sbus + "scale = \"futaba\"\n" + rest, status_with("good", "1000"));
    // 1000 us are 192 in Betaflight's scale, which Futaba's reads as 1000 - 160 * 1000 / 1344.
    EXPECT_NE(text.find("  channel 1: 1000 us now, then 881 us\n"), std::string::npos) << text;
}

TEST(LiveDifference, TellsThatAnOutputWouldFallIntoFailsafe) {
    const std::string text = difference(
        kJob,
        main_job_with(3, "device = \"/dev/ttyA\"\nfailsafe_when = [{ channel = 3, below = 990 }]"),
        kSticks);
    EXPECT_EQ(text.find("with the inputs as they are now (receiver good):\n"
                        "output servos: under control of receiver now, then in failsafe\n"),
              0U)
        << text;
}

TEST(LiveDifference, ShowsPresetsWhereTheReceiverIsNotGood) {
    EXPECT_EQ(
        difference(kJob, kJob + "[pipeline.main.failsafe]\npreset = { 3 = 900, other = 1500 }\n",
                   status_with("failsafe", "1100,1500,988")),
        "with the inputs as they are now (receiver not good):\n"
        "output servos:\n"
        "  channel 3: 988 us now, then 900 us\n");
}

TEST(LiveDifference, ShowsAllThatANewOutputWouldSay) {
    const std::string text =
        difference(kJob,
                   kJob +
                       "[output.tail]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyC\"\n"
                       "[pipeline.tail]\nfrom = \"receiver\"\nto = \"tail\"\n",
                   kSticks);
    EXPECT_NE(text.find("output tail: new, under control of receiver\n  channel 1: 1100 us\n"),
              std::string::npos)
        << text;
}

/// An input with another protocol is new and has received nothing, whatever its name.
TEST(LiveDifference, TellsThatAnotherProtocolOnThatPortHearsNothing) {
    const std::string text = difference(kJob, main_job_with(2, "protocol = \"sbus\""), kSticks);
    EXPECT_NE(text.find("output servos: under control of receiver now, then in failsafe\n"),
              std::string::npos)
        << text;
}

TEST(LiveDifference, DoesNotFeedAnInputOnAnotherDevice) {
    const std::string text = difference(kJob, main_job_with(3, "device = \"/dev/ttyC\""), kSticks);
    EXPECT_NE(text.find("output servos: under control of receiver now, then in failsafe\n"),
              std::string::npos)
        << text;
}

TEST(LiveDifference, IsNotMisledByGuardsThatCountAtALossOrAStartOnly) {
    const std::string guarded =
        main_job_with(3, "device = \"/dev/ttyA\"\nfrozen = \"2s\"") +
        "[pipeline.main.failsafe]\nrelease_when = { channel = 3, below = 900 }\n";
    EXPECT_EQ(
        difference(guarded, guarded + "[pipeline.main.channels]\n1 = { fixed = 1000 }\n", kSticks),
        "with the inputs as they are now (receiver good):\n"
        "output servos:\n"
        "  channel 1: 1100 us now, then 1000 us\n");
}

/// Each protocol with an encoder can be repeated: the frames are made as a sender makes them.
class LiveProtocols : public ::testing::TestWithParam<std::string_view> {};

TEST_P(LiveProtocols, AreRepeatedAsTheirSenderMakesThem) {
    const std::string job = std::string(GetParam()) +
                            "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                            "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n";
    const std::string sticks =
        "1100,1500,1000,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,"
        "1500,1500,1500";
    const std::string text =
        difference(job, job + "[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n",
                   status_with("good", sticks));
    EXPECT_EQ(text,
              "with the inputs as they are now (receiver good):\n"
              "output servos:\n"
              "  channel 1: 1100 us now, then 1900 us\n");
}

INSTANTIATE_TEST_SUITE_P(
    All, LiveProtocols,
    ::testing::Values("[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n",
                      "[input.receiver]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n",
                      "[input.receiver]\nprotocol = \"can\"\ninterface = \"can0\"\n",
                      "[input.receiver]\nprotocol = \"can\"\ninterface = \"can0\"\nfd = true\n"));

}  // namespace
}  // namespace tribus::test::live_difference_test
