#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/streams.h"
#include "tests/support/vectors.h"
#include "transports/codecs/srxl/srxl.h"

/// A frame of a receiver, and computed ones (tests/vectors/srxl.json).
namespace tribus::srxl_vectors_test {
namespace {

using nlohmann::json;

ChannelFrame frame_of(SrxlDecoder& decoder, const json& vector) {
    const auto frames =
        test::feed(decoder, test::from_hex(vector.at("bytes_hex").get<std::string>()));
    EXPECT_EQ(frames.size(), 1U) << vector["name"];
    EXPECT_EQ(decoder.skipped_bytes(), 0U) << vector["name"];
    return frames.empty() ? ChannelFrame{} : frames[0].channels;
}

// The sources have whole microseconds, cut towards 1500 or downwards.
TEST(SrxlVectors, ChannelsAreThoseOfTheSourceToAMicrosecond) {
    std::size_t seen = 0;
    for (const json& vector : test::vectors("srxl.json")) {
        ++seen;
        SrxlDecoder decoder;
        const ChannelFrame frame = frame_of(decoder, vector);
        EXPECT_TRUE(frame.good()) << vector["name"];
        const char* const key =
            vector.contains("channels_us") ? "channels_us" : "channels_us_ardupilot";
        const auto channels = vector.at(key).get<std::vector<double>>();
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            ASSERT_EQ(frame.has(channel), channel < channels.size()) << vector["name"] << channel;
            if (frame.has(channel)) {
                EXPECT_LT(std::abs(frame.channel(channel)->microseconds() - channels[channel]), 1)
                    << vector["name"] << " " << channel;
            }
        }
    }
    EXPECT_EQ(seen, 3U);
}

TEST(SrxlVectors, RawValuesAreThoseOfTheSource) {
    for (const json& vector : test::vectors("srxl.json")) {
        SrxlDecoder decoder;
        frame_of(decoder, vector);
        const auto read = decoder.details()[1].values;
        const json& raw = vector.at("raw");
        ASSERT_EQ(read.size(), raw.size()) << vector["name"];
        for (std::size_t i = 0; i < read.size(); ++i) {
            // Version 5 has them by channel, and the channel in the word.
            const bool numbered = raw.is_object();
            const int expected =
                numbered ? raw.at(std::to_string(read[i] >> 11U)).get<int>() : raw[i].get<int>();
            EXPECT_EQ(numbered ? read[i] & 0x7FF : read[i], expected) << vector["name"] << " " << i;
        }
    }
}

}  // namespace
}  // namespace tribus::srxl_vectors_test
