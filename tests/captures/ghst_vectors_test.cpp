#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/streams.h"
#include "tests/support/vectors.h"
#include "transports/codecs/ghst/ghst.h"

/// Frames of the unit tests of other programs, computed ones, and wrong ones
/// (tests/vectors/ghst.json).
namespace tribus::ghst_vectors_test {
namespace {

using nlohmann::json;

bool is_wrong(const json& vector) {
    return vector.at("kind").get<std::string>().rfind("negative", 0) == 0;
}

std::vector<DecodedFrame> frames_of(GhstDecoder& decoder, const json& vector) {
    return test::all_frames(decoder, test::from_hex(vector.at("bytes_hex").get<std::string>()));
}

TEST(GhstVectors, ChannelsAndRawValuesAreThoseOfTheSource) {
    std::size_t seen = 0;
    for (const json& vector : test::vectors("ghst.json")) {
        if (is_wrong(vector)) {
            continue;
        }
        ++seen;
        GhstDecoder decoder;
        const auto frames = frames_of(decoder, vector);
        ASSERT_EQ(frames.size(), 1U) << vector["name"];
        EXPECT_EQ(decoder.skipped_bytes(), 0U) << vector["name"];
        const auto raw = vector.at("raw").get<std::vector<std::uint16_t>>();
        const auto read = decoder.details()[1].values;
        EXPECT_EQ(std::vector<std::uint16_t>(read.begin(), read.end()), raw) << vector["name"];
        const auto channels = vector.value("channels_us", std::vector<double>{});
        for (std::size_t channel = 0; channel < channels.size(); ++channel) {
            ASSERT_TRUE(frames[0].channels.has(channel)) << vector["name"] << " " << channel;
            EXPECT_EQ(frames[0].channels.channel(channel)->microseconds(), channels[channel])
                << vector["name"] << " " << channel;
        }
    }
    EXPECT_EQ(seen, 3U);
}

TEST(GhstVectors, StatisticsAreThoseOfTheSource) {
    std::size_t seen = 0;
    for (const json& vector : test::vectors("ghst.json")) {
        if (!vector.contains("fields")) {
            continue;
        }
        ++seen;
        GhstDecoder decoder;
        frames_of(decoder, vector);
        const RadioStatistics* statistics = decoder.radio_statistics();
        ASSERT_TRUE(statistics) << vector["name"];
        const json& fields = vector["fields"];
        EXPECT_EQ(statistics->link_quality, fields["lq"].get<int>());
        EXPECT_EQ(statistics->rssi_dbm, fields["rssi_dbm"].get<int>());
        EXPECT_EQ(statistics->mode, fields["rf_protocol"].get<int>());
        EXPECT_EQ(fields["tx_dbm"].get<int>(), 20);
        EXPECT_EQ(statistics->power_mw, 100) << "20 dBm";
    }
    EXPECT_EQ(seen, 1U);
}

TEST(GhstVectors, WrongFramesAreRefused) {
    std::size_t seen = 0;
    for (const json& vector : test::vectors("ghst.json")) {
        if (is_wrong(vector)) {
            ++seen;
            GhstDecoder decoder;
            EXPECT_TRUE(frames_of(decoder, vector).empty()) << vector["name"];
        }
    }
    EXPECT_EQ(seen, 1U);
}

}  // namespace
}  // namespace tribus::ghst_vectors_test
