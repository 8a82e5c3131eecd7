#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/channel_bytes.h"
#include "tests/support/edges.h"
#include "tests/support/vectors.h"
#include "transports/codecs/ppm/ppm.h"

/// The edges of a frame with the times of each one (tests/vectors/ppm.json).
namespace tribus::ppm_vectors_test {
namespace {

using nlohmann::json;

/// Records of the edges that go to `level`, of so many frames one behind the other.
test::Bytes edges_to(int level, const json& vector, int frames) {
    test::Bytes bytes;
    double before_us = 0;
    for (int frame = 0; frame < frames; ++frame) {
        for (const json& edge : vector.at("edges_us")) {
            if (edge.at(1) != level) {
                continue;
            }
            const double at_us =
                100'000 + frame * vector.at("frame_us").get<double>() + edge.at(0).get<double>();
            const auto eighths = static_cast<std::uint32_t>((at_us - before_us) * 8);
            test::append(bytes, test::edge_record(test::Edge::seen, eighths));
            before_us = at_us;
        }
    }
    return bytes;
}

TEST(PpmVectors, ChannelsAreThoseOfTheSourceByEitherEdge) {
    std::size_t seen = 0;
    for (const json& vector : test::vectors("ppm.json")) {
        for (const int level : {0, 1}) {
            PpmDecoder decoder(1);
            const auto frames = test::feed(decoder, edges_to(level, vector, 3));
            ASSERT_EQ(frames.size(), 1U) << "the second; the third lacks the pause behind it";
            EXPECT_EQ(test::pulses_of(frames[0].channels),
                      vector.at("channels_us").get<std::vector<double>>());
            ++seen;
        }
    }
    EXPECT_EQ(seen, 2U);
}

}  // namespace
}  // namespace tribus::ppm_vectors_test
