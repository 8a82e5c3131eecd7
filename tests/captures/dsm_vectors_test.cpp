#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/streams.h"
#include "tests/support/vectors.h"
#include "transports/codecs/dsm/dsm.h"

/// Frames of satellite receivers, mostly of ArduPilot's tests (tests/vectors/dsm.json).
namespace tribus::dsm_vectors_test {
namespace {

using nlohmann::json;

/// The frames of a vector, with a pause before each, until they count; the last that does.
std::optional<ChannelFrame> heard(const json& vector, DsmScale scale) {
    const test::Bytes bytes = test::from_hex(vector.at("bytes_hex").get<std::string>());
    DsmDecoder decoder(scale);
    std::vector<DecodedFrame> frames;
    for (int round = 0; round < 4; ++round) {
        for (std::size_t at = 0; at < bytes.size(); at += kDsmFrameBytes) {
            DecodedFrame late;
            decoder.silence(late);
            test::feed_into(frames, decoder, std::span(bytes).subspan(at, kDsmFrameBytes));
        }
    }
    EXPECT_EQ(decoder.skipped_bytes(), 0U) << vector["name"];
    EXPECT_EQ(test::count_of(decoder, "implausible"), 0U) << vector["name"];
    return frames.empty() ? std::nullopt : std::optional(frames.back().channels);
}

TEST(DsmVectors, ChannelsAreThoseOfTheSource) {
    std::size_t seen = 0;
    for (const json& vector : test::vectors("dsm.json")) {
        const bool one_phase_of_two = vector["name"] == "px4_capture_1";
        const auto spektrum = heard(vector, DsmScale::spektrum);
        const auto betaflight = heard(vector, DsmScale::betaflight);
        ASSERT_EQ(spektrum.has_value(), !one_phase_of_two) << vector["name"];
        if (!spektrum) {
            continue;
        }
        ++seen;
        const int steps = vector["resolution_bits"] == 10 ? 2 : 1;
        for (const auto& [number, raw] : vector["raw"].items()) {
            const auto channel = static_cast<std::size_t>(std::stoi(number));
            EXPECT_EQ(betaflight->channel(channel)->microseconds(),
                      raw.get<int>() * steps / 2.0 + 988)
                << vector["name"] << " " << number;
        }
        // ArduPilot exchanges the first three and cuts off what is behind the point.
        const auto& us = vector["channels_us_ardupilot"];
        for (std::size_t channel = 0; channel < us.size(); ++channel) {
            const std::size_t ours = channel == 0   ? 1
                                     : channel == 1 ? 2
                                     : channel == 2 ? 0
                                                    : channel;
            EXPECT_NEAR(spektrum->channel(ours)->microseconds(), us[channel].get<double>(), 1)
                << vector["name"] << " " << channel;
        }
    }
    EXPECT_EQ(seen, 6U);
}

TEST(DsmVectors, AFrameOfOnePhaseAloneHasItsNumbersAndDoesNotCount) {
    for (const json& vector : test::vectors("dsm.json")) {
        if (vector["name"] != "px4_capture_1") {
            continue;
        }
        const test::Bytes bytes = test::from_hex(vector.at("bytes_hex").get<std::string>());
        const DsmWire wire(bytes.data(), kDsmFrameBytes);
        const auto layout = DsmLayout::of(wire, DsmResolution::either);
        ASSERT_TRUE(layout);
        EXPECT_EQ(layout->resolution(), DsmResolution::bits_11);
        std::size_t channels = 0;
        for (std::size_t word = 0; word < kDsmWords; ++word) {
            const std::size_t channel = layout->words()[word];
            if (channel != DsmLayout::kNoChannel) {
                const int value = (bytes[2 + 2 * word] << 8 | bytes[3 + 2 * word]) & 0x7FF;
                EXPECT_EQ(value, vector["raw"][std::to_string(channel)].get<int>());
                ++channels;
            }
        }
        EXPECT_EQ(channels, vector["raw"].size());
    }
}

}  // namespace
}  // namespace tribus::dsm_vectors_test
