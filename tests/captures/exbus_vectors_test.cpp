#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/streams.h"
#include "tests/support/vectors.h"
#include "transports/codecs/exbus/exbus.h"

/// The examples of Jeti's text (tests/vectors/jeti_exbus.json).
namespace tribus::exbus_vectors_test {
namespace {

using nlohmann::json;

TEST(ExBusVectors, AreFramesAndChannelsAreThoseOfTheText) {
    std::size_t with_channels = 0;
    std::size_t without = 0;
    for (const json& vector : test::vectors("jeti_exbus.json")) {
        ExBusDecoder decoder;
        const auto frames =
            test::feed(decoder, test::from_hex(vector.at("bytes_hex").get<std::string>()));
        EXPECT_EQ(decoder.waiting(), 0U) << vector["name"];
        EXPECT_EQ(decoder.skipped_bytes(), 0U) << vector["name"];
        EXPECT_EQ(test::count_of(decoder, "checksum"), 0U) << vector["name"];
        if (!vector.contains("raw")) {
            EXPECT_TRUE(frames.empty()) << vector["name"];
            ++without;
            continue;
        }
        ++with_channels;
        ASSERT_EQ(frames.size(), 1U) << vector["name"];
        for (std::size_t channel = 0; channel < vector["raw"].size(); ++channel) {
            EXPECT_EQ(frames[0].channels.channel(channel)->eighths(),
                      vector["raw"][channel].get<int>());
            EXPECT_EQ(frames[0].channels.channel(channel)->microseconds(),
                      vector["channels_us"][channel].get<double>());
        }
    }
    EXPECT_EQ(with_channels, 1U);
    EXPECT_EQ(without, 2U);
}

}  // namespace
}  // namespace tribus::exbus_vectors_test
