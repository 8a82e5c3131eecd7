#include "config/check/absent_channels.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

namespace tribus::test::absent_channels_test {
namespace {

std::vector<std::string> remarks_on(std::string_view text) {
    std::vector<std::string> lines;
    for (const Mistake& remark : maps_of_absent_channels(loaded(text))) {
        lines.push_back(format_mistake(remark));
    }
    return lines;
}

std::string remark(std::string_view place, int output, int input, std::string_view protocol) {
    return "t.toml:" + std::string(place) + ": channel " + std::to_string(output) +
           " is made from channel " + std::to_string(input) + ", which input \"receiver\" (" +
           std::string(protocol) +
           ") may lack; while it is absent, an output whose format cannot mark absent channels "
           "sends its preset";
}
using Remarks = std::vector<std::string>;

TEST(MapsOfAbsentChannels, AreThoseBeyondFourteenForAnIbusInput) {
    EXPECT_EQ(remarks_on(main_job_with(10, "[pipeline.main.channels]\n3 = 17\n4 = 14")),
              Remarks{remark("11:5", 3, 17, "ibus")});
}

TEST(MapsOfAbsentChannels, AreTheSourcesOfSwitchesAndMixesToo) {
    EXPECT_EQ(remarks_on(main_job_with(10,
                                       "[pipeline.main.channels]\n"
                                       "5 = { from = 15, above = 1500 }\n"
                                       "6 = { mix = { 1 = 0.5, 18 = 0.5 } }\n"
                                       "7 = { fixed = 1500 }")),
              (Remarks{remark("11:5", 5, 15, "ibus"), remark("12:5", 6, 18, "ibus")}));
}

TEST(MapsOfAbsentChannels, AreNoneOfAnSbusInput) {
    EXPECT_EQ(
        remarks_on(main_job_with(2, "protocol = \"sbus\"") + "[pipeline.main.channels]\n3 = 18"),
        Remarks{});
}

TEST(MapsOfAbsentChannels, StandInTheMapOfTheInputWhereItMakesThem) {
    EXPECT_EQ(remarks_on(main_job_with(3, "device = \"/dev/ttyA\"\nmap = { 3 = 16 }")),
              Remarks{remark("4:13", 3, 16, "ibus")});
}

TEST(MapsOfAbsentChannels, AreNoneWhereTheMapOfTheInputMakesThemOfOthers) {
    EXPECT_EQ(remarks_on(main_job_with(3, "device = \"/dev/ttyA\"\nmap = { 16 = 3 }") +
                         "[pipeline.main.channels]\n3 = 16"),
              Remarks{});
}

TEST(MapsOfAbsentChannels, AreThoseBeyondSixteenForANativeInput) {
    EXPECT_EQ(remarks_on("[input.receiver]\nprotocol = \"can\"\ninterface = \"can0\"\n"
                         "channels = 16\n"
                         "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                         "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
                         "[pipeline.main.channels]\n1 = 17\n2 = 16\n"),
              Remarks{remark("12:5", 1, 17, "can")});
}

/// The sender of an RCInput decides how many channels it has.
TEST(MapsOfAbsentChannels, AreNoneOfADroneCanInput) {
    EXPECT_EQ(remarks_on("[input.receiver]\nprotocol = \"dronecan\"\ninterface = \"can0\"\n"
                         "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                         "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
                         "[pipeline.main.channels]\n1 = 17\n"),
              Remarks{});
}

/// Channel 1 of the input may be absent, and channel 16 of its sender.
TEST(MapsOfAbsentChannels, AreThoseOfChannelsThatTheMapOfTheInputMakesOfThem) {
    EXPECT_EQ(remarks_on(main_job_with(3, "device = \"/dev/ttyA\"\nmap = { 1 = 16 }") +
                         "[pipeline.main.channels]\n2 = { fixed = 1500 }\n3 = 1\n4 = 2\n"),
              (Remarks{remark("4:13", 1, 16, "ibus"), remark("13:5", 3, 1, "ibus")}));
}

}  // namespace
}  // namespace tribus::test::absent_channels_test
