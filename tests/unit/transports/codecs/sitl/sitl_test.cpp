#include "transports/codecs/sitl/sitl.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/channel_bytes.h"
#include "tests/support/streams.h"
#include "tests/unit/config/main_job.h"
#include "transports/links/serial/serial_medium.h"
#include "transports/links/udp/udp_medium.h"
#include "transports/registry/registry.h"

namespace tribus::test::sitl_test {
namespace {

Bytes encoded(const ChannelFrame& frame, std::size_t channels) {
    SitlEncoder encoder(channels);
    return test::encoded(encoder, frame);
}

std::string to_simulator(const std::string& lines) {
    return "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n"
           "[output.simulator]\nprotocol = \"sitl\"\n" +
           lines + "[pipeline.main]\nfrom = \"receiver\"\nto = \"simulator\"\n";
}

// The layout of ArduPilot's SITL_State.cpp: `uint16_t pwm[16]`, taken if the datagram has 16 or
// 32 bytes.
TEST(Sitl, WritesEightOrSixteenWordsTheLowByteFirst) {
    ChannelFrame frame = frame_of_microseconds({1500, 1000, 2000, 988, 2012, 1, 4095, 1100, 1200});
    EXPECT_EQ(encoded(frame, 8), from_hex("dc05 e803 d007 dc03 dc07 0100 ff0f 4c04"));
    EXPECT_EQ(encoded(frame, 16), from_hex("dc05 e803 d007 dc03 dc07 0100 ff0f 4c04"
                                           "b004 dc05 dc05 dc05 dc05 dc05 dc05 dc05"));
}

TEST(Sitl, WritesNeitherAZeroWhichWouldKeepTheValueBeforeNor4096) {
    for (int eighths = -32768; eighths <= 32767; ++eighths) {
        ChannelFrame frame;
        frame.set(0, Pulse::from_eighths(eighths));
        const Bytes bytes = encoded(frame, 8);
        const int word = bytes[0] | bytes[1] << 8;
        ASSERT_EQ(word, std::clamp((eighths + 4) >> 3, 1, 4095)) << eighths;
    }
    EXPECT_EQ(SitlEncoder(8).needed_channels({}), 0xFFU);
    EXPECT_EQ(SitlEncoder(16).needed_channels({}), 0xFFFFU);
}

TEST(Sitl, GoesByUdpOnlyAndToItsOutputOnly) {
    ASSERT_EQ(find_protocol("sitl"), &kSitlProtocol);
    EXPECT_TRUE(carries(kUdpMedium, kSitlProtocol));
    EXPECT_FALSE(carries(kSerialMedium, kSitlProtocol));
    EXPECT_EQ(media_for(kSitlProtocol), std::vector<const Medium*>{&kUdpMedium});
    EXPECT_FALSE(kSitlProtocol.goes(SettingScope::input));
    EXPECT_EQ(mistakes_in(to_simulator("address = \"127.0.0.1:5501\"\nchannels = 8\n")),
              std::vector<std::string>{});
    EXPECT_EQ(mistakes_in(to_simulator("device = \"/dev/ttyB\"\n")),
              std::vector<std::string>{
                  "t.toml:6:1: unknown key \"device\" in [output.simulator]; protocol \"sitl\" has "
                  "\"address\" instead: IP address and port for UDP, one frame a datagram: an "
                  "input receives there, an output sends there"});
}

TEST(Sitl, RefusesOtherNumbersOfChannels) {
    for (int channels = 8; channels <= 16; ++channels) {
        const auto mistakes = mistakes_in(to_simulator(
            "address = \"127.0.0.1:5501\"\nchannels = " + std::to_string(channels) + "\n"));
        if (channels == 8 || channels == 16) {
            EXPECT_EQ(mistakes, std::vector<std::string>{}) << channels;
            continue;
        }
        EXPECT_EQ(mistakes, std::vector<std::string>{
                                "t.toml:7:12: \"channels\" is " + std::to_string(channels) +
                                ", and SITL reads datagrams of two lengths only; allowed: 8, 16"});
    }
}

TEST(Media, EveryProtocolHasAMediumAndNamesOneThatExists) {
    for (const Protocol* protocol : protocols()) {
        EXPECT_FALSE(media_for(*protocol).empty()) << protocol->name;
        EXPECT_TRUE(protocol->only_on.empty() ||
                    std::ranges::count(media(), protocol->only_on, &Medium::name) == 1)
            << protocol->name;
    }
}

}  // namespace
}  // namespace tribus::test::sitl_test
