#include "transports/codecs/ghst/ghst.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/plain_ghst.h"
#include "tests/support/channel_bytes.h"
#include "tests/support/heard_line.h"
#include "tests/support/streams.h"
#include "transports/registry/registry.h"

namespace tribus::test::ghst_test {
namespace {

using namespace std::chrono_literals;
using reference::plain_ghst;
using reference::plain_ghst_payload;

// Computed from Betaflight's ghst_protocol.h: all channels centred, and the statistics.
constexpr std::string_view kCentred = "820C3000088000088080808080D2";
constexpr std::string_view kStatistics = "820C33000880000880643C0514E3";
// ArduPilot, test_ghst_resync.cpp, make_frame of 1 and 2.
constexpr std::string_view kFirst = "820C30255442255442747576776C";
constexpr std::string_view kSecond = "820C304AA4444AA4447B7C7D7E4F";
constexpr std::array<std::uint8_t, 6> kGroupTypes{0x30, 0x31, 0x32, 0x10, 0x11, 0x12};

std::size_t first_of(std::uint8_t type) {
    return 4 + 4 * (type % 16U);
}

Bytes frame_of(std::uint8_t type, unsigned fine, unsigned coarse) {
    return plain_ghst(
        type, plain_ghst_payload({fine, fine, fine, fine}, {coarse, coarse, coarse, coarse}));
}

Bytes statistics(std::uint8_t link_quality) {
    return plain_ghst(0x33,
                      plain_ghst_payload({2048, 2048, 2048, 2048}, {link_quality, 60, 5, 20}));
}

using Line = HeardLine<GhstDecoder>;

TEST(GhstDecoder, ReadsTheFramesOfTheSources) {
    for (const auto& [hex, fine, coarse] :
         {std::tuple(kCentred, 1500.0, std::array{1500.0, 1500.0, 1500.0, 1500.0}),
          std::tuple(kFirst, 1253.25, std::array{1452.0, 1456.0, 1460.0, 1464.0}),
          std::tuple(kSecond, 1262.5, std::array{1480.0, 1484.0, 1488.0, 1492.0})}) {
        Line line;
        const auto frame = line.hear(from_hex(hex), 0ms);
        ASSERT_TRUE(frame);
        EXPECT_TRUE(frame->good());
        EXPECT_EQ(present(*frame), (std::vector<std::size_t>{1, 2, 3, 4, 5, 6, 7, 8}));
        for (std::size_t i = 0; i < 4; ++i) {
            EXPECT_EQ(frame->channel(i)->microseconds(), fine);
            EXPECT_EQ(frame->channel(4 + i)->microseconds(), coarse[i]);
        }
    }
}

TEST(GhstDecoder, ReadsEveryRawValueOfChannelsOneToFourExactly) {
    for (const std::uint8_t type : Bytes{0x30, 0x33, 0x10, 0x13}) {
        GhstDecoder decoder;
        for (unsigned raw = 0; raw <= 4095; ++raw) {
            const std::array<unsigned, 4> fine{raw, raw ^ 0xFFFU, (raw + 1365) % 4096,
                                               (raw * 7) % 4096};
            const auto frames = feed(decoder, plain_ghst(type, plain_ghst_payload(fine, {})));
            ASSERT_EQ(frames.size(), 1U);
            for (std::size_t i = 0; i < 4; ++i) {
                ASSERT_EQ(frames[0].channels.channel(i)->microseconds(),
                          reference::plain_ghst_fine_us(type >= 0x30, fine[i]))
                    << int{type} << " " << fine[i];
            }
        }
    }
}

TEST(GhstDecoder, ReadsEveryRawValueOfEveryOtherChannelExactly) {
    for (const std::uint8_t type : kGroupTypes) {
        GhstDecoder decoder;
        for (unsigned raw = 0; raw <= 255; ++raw) {
            const std::array<unsigned, 4> coarse{raw, raw ^ 0xFFU, (raw + 85) % 256,
                                                 (raw * 7) % 256};
            const auto frames = feed(decoder, plain_ghst(type, plain_ghst_payload({}, coarse)));
            ASSERT_EQ(frames.size(), 1U);
            for (std::size_t i = 0; i < 4; ++i) {
                ASSERT_EQ(frames[0].channels.channel(first_of(type) + i)->microseconds(),
                          reference::plain_ghst_coarse_us(type >= 0x30, coarse[i]))
                    << int{type} << " " << coarse[i];
            }
        }
    }
}

TEST(GhstDecoder, OldTypesHaveTheirOwnScale) {
    Line line;
    // 344 and 22 are the ends of EdgeTX's travel; Betaflight: 172 and 22 of SBUS's are 988 us.
    const auto low = line.hear(frame_of(0x10, 344, 22), 0ms);
    ASSERT_TRUE(low);
    EXPECT_EQ(low->channel(0)->microseconds(), 988);
    EXPECT_EQ(low->channel(4)->microseconds(), 990);
    const auto centre = line.hear(frame_of(0x10, 1984, 124), 4ms);
    ASSERT_TRUE(centre);
    EXPECT_EQ(centre->channel(0)->microseconds(), 1500.5);
    EXPECT_EQ(centre->channel(4)->microseconds(), 1500);
    EXPECT_EQ(line.hear(frame_of(0x10, 0, 0), 8ms)->channel(0)->microseconds(), 880.5);
}

TEST(GhstDecoder, EachFrameGivesTheChannelsThatItsTypeHas) {
    for (unsigned type = 0; type <= 0xFF; ++type) {
        Line line;
        const auto frame = line.hear(frame_of(static_cast<std::uint8_t>(type), 2048, 128), 0ms);
        if (type / 16 != 1 && type / 16 != 3) {
            EXPECT_FALSE(frame) << type;
            continue;
        }
        ASSERT_TRUE(frame) << type;
        std::vector<std::size_t> expected{1, 2, 3, 4};
        for (std::size_t i = 0; i < 4 && type % 16 < 3; ++i) {
            expected.push_back(first_of(static_cast<std::uint8_t>(type)) + i + 1);
        }
        EXPECT_EQ(present(*frame), expected) << type;
        EXPECT_EQ(line.decoder().radio_statistics() != nullptr, type % 16 == 3) << type;
    }
}

TEST(GhstDecoder, PassesOverOtherTypesWithoutCountingThem) {
    Bytes bytes = frame_of(0x21, 2048, 128);
    append(bytes, from_hex(kCentred));
    GhstDecoder decoder;
    const auto frames = feed(decoder, bytes);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].first_byte, 14U);
    EXPECT_EQ(decoder.skipped_bytes(), 0U);
    EXPECT_EQ(count_of(decoder, "checksum"), 0U);
}

TEST(GhstDecoder, TakesNoLengthButTwelve) {
    for (std::size_t payload = 0; payload <= 60; ++payload) {
        for (const std::uint8_t type : Bytes{0x30, 0x33, 0x10, 0x21}) {
            GhstDecoder decoder;
            const auto frames = all_frames(decoder, plain_ghst(type, Bytes(payload, 0x55)));
            EXPECT_EQ(frames.size(), payload == 10 && type != 0x21 ? 1U : 0U)
                << payload << " " << int{type};
        }
    }
}

TEST(GhstDecoder, TakesNoAddressButThatOfAFlightController) {
    for (unsigned address = 0; address <= 0xFF; ++address) {
        GhstDecoder decoder;
        const auto bytes = plain_ghst(0x30, Bytes(10, 0x55), static_cast<std::uint8_t>(address));
        EXPECT_EQ(all_frames(decoder, bytes).size(), address == 0x82 ? 1U : 0U) << address;
    }
}

TEST(GhstDecoder, AGroupIsAbsentBeforeItComesAndHalfASecondAfter) {
    for (const std::uint8_t type : kGroupTypes) {
        Line line;
        const auto plain = [&](Duration at) { return *line.hear(frame_of(0x34, 2048, 9), at); };
        const std::size_t first = first_of(type);
        EXPECT_FALSE(plain(0ms).has(first));
        EXPECT_TRUE(line.hear(frame_of(type, 2048, 50), 4ms)->has(first));
        const ChannelFrame last = plain(504ms);
        EXPECT_EQ(present(last), (std::vector<std::size_t>{1, 2, 3, 4, first + 1, first + 2,
                                                           first + 3, first + 4}));
        EXPECT_EQ(last.channel(first)->microseconds(), type >= 0x30 ? 1188 : 1130);
        EXPECT_EQ(present(plain(505ms)), (std::vector<std::size_t>{1, 2, 3, 4}));
        EXPECT_EQ(plain(506ms).pulses()[first], Pulse{});
        EXPECT_TRUE(line.hear(frame_of(type, 2048, 51), 2s)->has(first));
    }
}

TEST(GhstDecoder, ARenewedGroupDoesNotKeepTheOthers) {
    Line line;
    line.hear(frame_of(0x30, 2048, 1), 0ms);
    line.hear(frame_of(0x32, 2048, 2), 1ms);
    for (Duration at = 5ms; at <= 500ms; at += 5ms) {
        line.hear(frame_of(0x31, 2048, 3), at);
    }
    EXPECT_EQ(present(*line.hear(frame_of(0x31, 2048, 3), 501ms)),
              (std::vector<std::size_t>{1, 2, 3, 4, 9, 10, 11, 12, 13, 14, 15, 16}));
    EXPECT_EQ(present(*line.hear(frame_of(0x31, 2048, 3), 502ms)),
              (std::vector<std::size_t>{1, 2, 3, 4, 9, 10, 11, 12}));
}

TEST(GhstDecoder, ReadsStatistics) {
    Line line;
    EXPECT_EQ(line.decoder().radio_statistics(), nullptr);
    line.hear(from_hex(kStatistics), 3ms);
    const RadioStatistics* statistics = line.decoder().radio_statistics();
    ASSERT_TRUE(statistics);
    EXPECT_EQ(statistics->link_quality, 100);
    EXPECT_EQ(statistics->rssi_dbm, -60);
    EXPECT_EQ(statistics->snr_db, std::nullopt);
    EXPECT_EQ(statistics->mode, 5);
    EXPECT_EQ(statistics->power_mw, 100);
    EXPECT_EQ(statistics->received, Line::kStart + 3ms);
}

TEST(GhstDecoder, ReadsStatisticsOfEveryByteInBothTypes) {
    for (const std::uint8_t type : Bytes{0x33, 0x13}) {
        for (unsigned byte = 0; byte <= 0xFF; ++byte) {
            Line line;
            const auto frame =
                line.hear(plain_ghst(type, plain_ghst_payload({}, {byte, byte, byte, byte})), 0ms);
            const RadioStatistics* statistics = line.decoder().radio_statistics();
            ASSERT_TRUE(frame);
            ASSERT_TRUE(statistics);
            const unsigned quality = byte <= 100 ? byte : kNoLinkQuality;
            EXPECT_EQ(statistics->link_quality, quality);
            EXPECT_EQ(frame->link_quality, quality);
            EXPECT_EQ(statistics->rssi_dbm, -static_cast<int>(byte));
            EXPECT_EQ(statistics->mode, byte % 32);
            const int dbm = byte < 128 ? static_cast<int>(byte) : static_cast<int>(byte) - 256;
            ASSERT_EQ(statistics->power_mw.has_value(), dbm <= 48);
            if (dbm <= 48) {
                EXPECT_NEAR(*statistics->power_mw, std::exp(dbm * std::log(10) / 10), 0.51);
            }
        }
    }
}

TEST(GhstDecoder, ChannelsCarryTheLinkQualityOfStatisticsForASecond) {
    Line line;
    EXPECT_EQ(line.hear(from_hex(kCentred), 0ms)->link_quality, kNoLinkQuality);
    EXPECT_EQ(line.hear(statistics(87), 2ms)->link_quality, 87);
    EXPECT_EQ(line.hear(from_hex(kCentred), 4ms)->link_quality, 87);
    EXPECT_EQ(line.hear(from_hex(kCentred), 1002ms)->link_quality, 87);
    EXPECT_EQ(line.hear(from_hex(kCentred), 1003ms)->link_quality, kNoLinkQuality);
}

TEST(GhstDecoder, DetailsAreThoseOfTheLatestFrame) {
    Line line;
    EXPECT_TRUE(line.decoder().details().empty());
    line.hear(from_hex(kFirst), 0ms);
    const auto values = [&](std::size_t at) {
        const FrameDetail& detail = line.decoder().details()[at];
        return std::vector<std::uint16_t>(detail.values.begin(), detail.values.end());
    };
    ASSERT_EQ(line.decoder().details().size(), 2U);
    EXPECT_EQ(line.decoder().details()[0].name, "type");
    EXPECT_EQ(values(0), std::vector<std::uint16_t>{0x30});
    EXPECT_EQ(line.decoder().details()[1].name, "raw");
    EXPECT_EQ(values(1), (std::vector<std::uint16_t>{1061, 1061, 1061, 1061, 116, 117, 118, 119}));
    line.hear(from_hex(kStatistics), 4ms);
    ASSERT_EQ(line.decoder().details().size(), 4U);
    EXPECT_EQ(values(1), (std::vector<std::uint16_t>{2048, 2048, 2048, 2048}));
    EXPECT_EQ(line.decoder().details()[2].name, "link_quality");
    EXPECT_EQ(values(2), std::vector<std::uint16_t>{100});
    EXPECT_EQ(line.decoder().details()[3].name, "rssi_minus_dbm");
    EXPECT_EQ(values(3), std::vector<std::uint16_t>{60});
}

TEST(Ghst, IsInTheRegistryAndHeardByDoctor) {
    EXPECT_EQ(find_protocol("ghst"), &kGhstProtocol);
    std::vector<Bytes> bursts;
    for (unsigned i = 0; i < 4; ++i) {
        bursts.push_back(frame_of(static_cast<std::uint8_t>(0x30 + i), 2048, 90));
    }
    const doctor::LineStory story = story_of(kGhstProtocol, bursts, 4ms);
    EXPECT_EQ(story.protocol, "ghst");
    EXPECT_EQ(story.channels, 16U);
    EXPECT_EQ(story.period, std::optional<Duration>(4ms));
}

}  // namespace
}  // namespace tribus::test::ghst_test
