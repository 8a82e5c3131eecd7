#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/streams.h"
#include "tests/support/vectors.h"
#include "transports/codecs/fport/fport.h"

/// Frames of the tests of ArduPilot (tests/vectors/fport.json).
namespace tribus::fport_vectors_test {
namespace {

using nlohmann::json;

std::unique_ptr<ByteDecoder> decoder_of(const json& vector, const SbusScale& scale) {
    if (vector.at("protocol") == "fport") {
        return std::make_unique<FportDecoder>(scale);
    }
    return std::make_unique<Fport2Decoder>(scale);
}

TEST(FportVectors, AreReadInRawValuesAndMicroseconds) {
    std::size_t seen = 0;
    for (const json& vector : test::vectors("fport.json")) {
        ++seen;
        const auto decoder = decoder_of(vector, *SbusScale::named("betaflight"));
        const auto frames =
            test::feed(*decoder, test::from_hex(vector.at("bytes_hex").get<std::string>()));
        ASSERT_EQ(frames.size(), 1U) << vector["name"];
        EXPECT_TRUE(frames[0].channels.good());
        const auto raw = vector.at("raw").get<std::vector<std::uint16_t>>();
        const auto details = decoder->details();
        ASSERT_EQ(details.size(), 2U);
        EXPECT_EQ(std::vector<std::uint16_t>(details[0].values.begin(), details[0].values.end()),
                  raw);
        EXPECT_EQ(details[1].values[0], vector["flags"]["rssi"].get<std::uint16_t>());
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            ASSERT_EQ(frames[0].channels.has(channel), channel < raw.size());
            if (channel < raw.size()) {
                EXPECT_EQ(frames[0].channels.channel(channel)->microseconds(),
                          0.625 * raw[channel] + 880);
            }
            if (vector.contains("channels_us") && channel < raw.size()) {
                EXPECT_EQ(frames[0].channels.channel(channel)->microseconds(),
                          vector["channels_us"][channel].get<double>());
            }
        }
        EXPECT_EQ(decoder->skipped_bytes(), 0U);
    }
    EXPECT_EQ(seen, 3U);
}

TEST(FportVectors, WithTheScaleOfArduPilotGiveItsMicroseconds) {
    for (const json& vector : test::vectors("fport.json")) {
        const bool eighteen = vector.contains("channels_us_ardupilot_first18");
        const auto expected =
            vector.at(eighteen ? "channels_us_ardupilot_first18" : "channels_us_ardupilot")
                .get<std::vector<int>>();
        const auto decoder = decoder_of(vector, *SbusScale::named("ardupilot"));
        const auto frames =
            test::feed(*decoder, test::from_hex(vector.at("bytes_hex").get<std::string>()));
        ASSERT_EQ(frames.size(), 1U) << vector["name"];
        for (std::size_t channel = 0; channel < expected.size(); ++channel) {
            // Half a microsecond lower, rounded (docs/protocols/sbus.md, "Scales").
            EXPECT_NEAR(frames[0].channels.channel(channel)->microseconds(), expected[channel], 0.5)
                << vector["name"] << " " << channel;
        }
    }
}

}  // namespace
}  // namespace tribus::fport_vectors_test
