#include "transports/links/pulse_line/waveform.h"

#include <cstddef>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/edges.h"

/// Records of edges as the bits of an SPI port.
namespace tribus::test::waveform_test {
namespace {

/// Where the line is up: first bit, and the first one behind it.
using Ups = std::vector<std::pair<std::size_t, std::size_t>>;

Ups ups_of(const SpiWaveform& waveform) {
    Ups ups;
    bool before = false;
    for (std::size_t bit = 0; bit <= waveform.bytes * 8; ++bit) {
        const bool up =
            bit < waveform.bytes * 8 && (waveform.bits.at(bit / 8) >> (7 - bit % 8) & 1) != 0;
        if (up && !before) {
            ups.emplace_back(bit, bit);
        } else if (before && !up) {
            ups.back().second = bit;
        }
        before = up;
    }
    return ups;
}

Ups drawn(const Bytes& records, double calibration = 1) {
    SpiWaveform waveform;
    EXPECT_TRUE(draw_pulses(records, calibration, waveform));
    return ups_of(waveform);
}

TEST(Waveform, HasAPulseOf300MicrosecondsAtEachEdge) {
    EXPECT_EQ(drawn(ppm_frame({1500, 1000, 2000, 1234})),
              (Ups{{0, 300}, {1500, 1800}, {2500, 2800}, {4500, 4800}, {5734, 6034}}));
}

TEST(Waveform, EndsWithThePauseBehindTheLastEdge) {
    SpiWaveform waveform;
    ASSERT_TRUE(draw_pulses(ppm_frame({1500, 1000, 2000, 1236}), 1, waveform));
    EXPECT_EQ(waveform.bytes * 8, 1500U + 1000 + 2000 + 1236 + 2700 + 4) << "whole bytes";
    ASSERT_TRUE(draw_pulses(ppm_frame({1500}), 1, waveform)) << "what was drawn before is gone";
    EXPECT_EQ(ups_of(waveform), (Ups{{0, 300}, {1500, 1800}}));
}

TEST(Waveform, HasAsManyBytesAsItsBitsNeed) {
    const auto bytes_of = [](double last) {
        SpiWaveform waveform;
        EXPECT_TRUE(draw_pulses(ppm_frame({last}), 1, waveform));
        return waveform.bytes;
    };
    EXPECT_EQ(bytes_of(1004), 463U) << "3704 bits";
    EXPECT_EQ(bytes_of(1005), 464U) << "3705 bits";
    EXPECT_EQ(bytes_of(1012), 464U) << "3712 bits";
}

TEST(Waveform, HasRoomForExactly32768Bits) {
    const auto fits = [](std::uint32_t eighths) {
        Bytes records = edge_record(Edge::seen, 0);
        append(records, edge_record(Edge::seen, eighths));
        SpiWaveform waveform;
        return draw_pulses(records, 1, waveform);
    };
    EXPECT_TRUE(fits(32468 * 8));
    EXPECT_FALSE(fits(32468 * 8 + 1));
}

TEST(Waveform, IsEmptyWhereItCouldNotBeDrawn) {
    SpiWaveform waveform;
    ASSERT_TRUE(draw_pulses(ppm_frame({1500}), 1, waveform));
    EXPECT_FALSE(draw_pulses(Bytes{1, 2, 3, 4, 5}, 1, waveform));
    EXPECT_EQ(waveform.bytes, 0U);
}

TEST(Waveform, RoundsEachEdgeAndNotEachDistance) {
    EXPECT_EQ(drawn(ppm_frame({1000.375, 1000.375, 1000.375, 1000.375})),
              (Ups{{0, 300}, {1000, 1300}, {2001, 2301}, {3001, 3301}, {4002, 4302}}));
}

// A clock that is 2 % too fast sends 1020 bits in the time of 1000.
TEST(Waveform, HasMoreBitsForAFastClock) {
    EXPECT_EQ(drawn(ppm_frame({1000, 1500}), 1.02), (Ups{{0, 306}, {1020, 1326}, {2550, 2856}}));
}

TEST(Waveform, HasRoomForTwelveOfTheLongestChannels) {
    // As the encoder writes them, on the fastest clock that a configuration allows.
    Bytes longest = ppm_edges(std::vector<double>(12, 2300));
    append(longest, edge_record(Edge::quiet, 3000 * 8));
    SpiWaveform waveform;
    EXPECT_TRUE(draw_pulses(longest, 1.05, waveform));
    EXPECT_FALSE(draw_pulses(longest, 1.1, waveform));
}

TEST(Waveform, IsNoneWithoutAnEdgeOrOfWrongRecords) {
    SpiWaveform waveform;
    EXPECT_FALSE(draw_pulses(quiet_record(), 1, waveform));
    EXPECT_FALSE(draw_pulses({}, 1, waveform));
    Bytes wrong = ppm_frame({1500});
    wrong[6] ^= 1;
    EXPECT_FALSE(draw_pulses(wrong, 1, waveform));
}

}  // namespace
}  // namespace tribus::test::waveform_test
