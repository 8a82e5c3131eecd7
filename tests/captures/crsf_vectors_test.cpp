#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/streams.h"
#include "tests/support/vectors.h"
#include "transports/codecs/crsf/crsf.h"

/// Frames of receivers, of the unit tests of other programs, and wrong ones
/// (tests/vectors/crsf.json).
namespace tribus::crsf_vectors_test {
namespace {

using nlohmann::json;

std::vector<DecodedFrame> frames_of(CrsfDecoder& decoder, const json& vector) {
    return test::all_frames(decoder, test::from_hex(vector.at("bytes_hex").get<std::string>()));
}

TEST(CrsfVectors, ChannelsAreThoseOfTheSource) {
    std::size_t seen = 0;
    for (const json& vector : test::vectors("crsf.json")) {
        if (vector.value("type", "") != "0x16" || !vector.contains("channels_us")) {
            continue;
        }
        ++seen;
        CrsfDecoder decoder;
        const auto frames = frames_of(decoder, vector);
        ASSERT_EQ(frames.size(), 1U) << vector["name"];
        for (std::size_t channel = 0; channel < 16; ++channel) {
            EXPECT_EQ(frames[0].channels.channel(channel)->microseconds(),
                      vector["channels_us"][channel].get<double>())
                << vector["name"] << " " << channel;
        }
    }
    EXPECT_GE(seen, 4U);
}

TEST(CrsfVectors, OtherTypesAreFramesWithoutARejection) {
    for (const json& vector : test::vectors("crsf.json")) {
        const auto kind = vector.at("kind").get<std::string>();
        if (kind.rfind("negative", 0) == 0) {
            continue;
        }
        CrsfDecoder decoder;
        frames_of(decoder, vector);
        EXPECT_EQ(decoder.skipped_bytes(), 0U) << vector["name"];
        EXPECT_EQ(test::count_of(decoder, "checksum"), 0U) << vector["name"];
    }
}

TEST(CrsfVectors, WrongFramesAreRefused) {
    std::size_t seen = 0;
    for (const json& vector : test::vectors("crsf.json")) {
        if (vector.at("kind").get<std::string>().rfind("negative", 0) != 0) {
            continue;
        }
        ++seen;
        CrsfDecoder decoder;
        EXPECT_TRUE(frames_of(decoder, vector).empty()) << vector["name"];
    }
    EXPECT_EQ(seen, 2U);
}

}  // namespace
}  // namespace tribus::crsf_vectors_test
