#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/reference/plain_ibus2.h"
#include "tests/support/streams.h"
#include "tests/support/vectors.h"
#include "transports/codecs/ibus2/ibus2.h"

/// Frames of a FTr8B (tests/vectors/ibus2.json). It has no key; the one here is what the captures
/// show.
namespace tribus::ibus2_vectors_test {
namespace {

using nlohmann::json;

TEST(Ibus2Vectors, ChannelsAreThoseOfTheSource) {
    std::size_t seen = 0;
    for (const json& vector : test::vectors("ibus2.json")) {
        if (!vector.contains("channels_us")) {
            continue;
        }
        ++seen;
        const auto us = vector["channels_us"].get<std::vector<double>>();
        Ibus2Decoder decoder;
        test::feed(decoder, reference::plain_ibus2_key(std::vector<unsigned>(us.size(), 0x1B)));
        const auto frames =
            test::feed(decoder, test::from_hex(vector.at("bytes_hex").get<std::string>()));
        ASSERT_EQ(frames.size(), 1U) << vector["name"];
        EXPECT_TRUE(frames[0].channels.good());
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            ASSERT_EQ(frames[0].channels.has(channel), channel < us.size());
            if (channel < us.size()) {
                EXPECT_EQ(frames[0].channels.channel(channel)->microseconds(), us[channel])
                    << vector["name"] << " " << channel;
            }
        }
    }
    EXPECT_EQ(seen, 2U);
}

TEST(Ibus2Vectors, OtherFramesArePassedOverWithoutARejection) {
    std::size_t seen = 0;
    for (const json& vector : test::vectors("ibus2.json")) {
        if (vector.contains("channels_us")) {
            continue;
        }
        ++seen;
        Ibus2Decoder decoder;
        EXPECT_TRUE(
            test::feed(decoder, test::from_hex(vector.at("bytes_hex").get<std::string>())).empty());
        EXPECT_EQ(decoder.skipped_bytes(), 0U) << vector["name"];
        EXPECT_EQ(decoder.waiting(), 0U) << vector["name"];
        EXPECT_EQ(test::count_of(decoder, "checksum"), 0U) << vector["name"];
    }
    EXPECT_EQ(seen, 2U);
}

}  // namespace
}  // namespace tribus::ibus2_vectors_test
