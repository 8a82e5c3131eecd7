#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/stream_rules.h"
#include "tests/unit/transports/codecs/ibus2/ibus2_frames.h"

namespace tribus::test::ibus2_stream_test {
namespace {

using namespace ibus2_frames;

TEST(Ibus2Decoder, PassesOverFailsafeValuesCommandsAndReplies) {
    for (const Split split : {kOneRead, kByteByByte}) {
        Ibus2Decoder decoder;
        Bytes bytes = plain_ibus2_key(Types(8, kUsualType));
        append(bytes, four_cycles());
        append(bytes, plain_ibus2_to_all(0x08, std::vector<std::uint8_t>(11, 0x55)));
        const auto frames = all_frames(decoder, bytes, split);
        ASSERT_EQ(frames.size(), 4U);
        EXPECT_TRUE(frames[3].channels.has_first(8));
        EXPECT_EQ(decoder.skipped_bytes(), 0U);
        EXPECT_EQ(count_of(decoder, "checksum"), 0U);
    }
}

TEST(Ibus2Decoder, TakesNoOtherFirstByteAndLength) {
    for (unsigned first = 0; first <= 0xFF; ++first) {
        for (std::size_t length = 2; length <= 60; ++length) {
            Bytes bytes(length - 1, 0x07);
            bytes[0] = static_cast<std::uint8_t>(first);
            if (length >= 3) {
                bytes[1] = static_cast<std::uint8_t>(length);
            }
            bytes = plain_ibus2_checked(bytes);
            Ibus2Decoder decoder;
            all_frames(decoder, bytes);
            const bool to_all =
                first % 4 == 0 && first / 4 % 16 <= 2 && length >= 4 && length <= 37;
            const bool to_one =
                (first % 4 == 1 || first % 4 == 2) && first / 4 <= 4 && length == 21;
            ASSERT_EQ(decoder.skipped_bytes() == 0, to_all || to_one) << first << " " << length;
        }
    }
}

TEST(Ibus2Decoder, RefusesEachFlippedBit) {
    for (const Bytes& good : {from_hex(kCaptured18), from_hex(kCaptured8)}) {
        for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
            Bytes bytes = good;
            bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
            for (const Split split : {kOneRead, kByteByByte}) {
                Ibus2Decoder decoder;
                feed(decoder, plain_ibus2_key(Types(good.size() == 29 ? 18 : 8, kUsualType)));
                for (const DecodedFrame& frame : all_frames(decoder, bytes, split)) {
                    EXPECT_FALSE(frame.channels.has_any()) << bit;
                }
            }
        }
    }
}

TEST(Ibus2Decoder, AKeyWithAFlippedBitIsNone) {
    const Bytes good = plain_ibus2_key(Types(8, kUsualType));
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
        Bytes bytes = good;
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
        append(bytes, from_hex(kCaptured8));
        append(bytes, from_hex(kCaptured8));
        Ibus2Decoder decoder;
        const auto frames = all_frames(decoder, bytes);
        ASSERT_GE(frames.size(), 1U) << bit;
        for (const DecodedFrame& frame : frames) {
            EXPECT_FALSE(frame.channels.has_any()) << bit;
        }
    }
}

TEST(Ibus2Decoder, LosesOneFrameAtMostByAByteThatIsLostOrAddedAnywhere) {
    const Bytes key = plain_ibus2_key(Types(8, kUsualType));
    const Bytes good = four_cycles();
    std::size_t hurt = 0;
    std::size_t cases = 0;
    for (std::size_t at = 0; at < good.size(); ++at) {
        std::vector<Fault> faults{{FaultKind::lost, at}, {FaultKind::damaged, at}};
        for (const std::uint8_t value : Bytes{0x00, 0x05, 0x06, 0x07, 0x0F, 0x25, 0xFF}) {
            faults.push_back({FaultKind::added, at, value});
        }
        for (const Fault& fault : faults) {
            for (const Split split : {kOneRead, kByteByByte}) {
                Ibus2Decoder decoder;
                feed(decoder, key);
                const auto frames = all_frames(decoder, good, split, fault);
                const auto whole = std::ranges::count_if(
                    frames, [](const DecodedFrame& frame) { return frame.channels.has_first(8); });
                EXPECT_GE(whole, 3) << fault;
                EXPECT_LE(whole, 4) << fault;
                hurt += whole == 3 ? 1U : 0U;
                ++cases;
            }
        }
    }
    EXPECT_LT(hurt, cases / 2);
}

TEST(Ibus2Decoder, FindsAFrameBehindAnyFalseBeginning) {
    const Bytes key = plain_ibus2_key(Types(8, kUsualType));
    const Bytes whole = from_hex(kCaptured8);
    for (std::size_t cut = 1; cut < whole.size(); ++cut) {
        Bytes bytes = key;
        append(bytes, std::span(whole).first(cut));
        append(bytes, whole);
        for (const Split split : {kOneRead, kByteByByte}) {
            Ibus2Decoder decoder;
            const auto frames = all_frames(decoder, bytes, split);
            ASSERT_EQ(frames.size(), 1U) << cut;
            EXPECT_EQ(frames[0].first_byte, key.size() + cut);
        }
    }
}

TEST(Ibus2Decoder, FindsAFrameInsideABadOneAndNoneInsideAGoodOne) {
    Bytes inside = from_hex(kCaptured8);
    inside.resize(19);
    Bytes outer{0x05};
    append(outer, inside);
    const Bytes good = plain_ibus2_checked(outer);
    Bytes bad = good;
    bad.back() = static_cast<std::uint8_t>(bad.back() ^ 0x10U);
    Ibus2Decoder in_good;
    EXPECT_TRUE(all_frames(in_good, good).empty());
    Ibus2Decoder in_bad;
    const auto frames = all_frames(in_bad, bad);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].first_byte, 1U);
    EXPECT_GE(count_of(in_bad, "checksum"), 1U);
}

TEST(Ibus2Decoder, APauseEndsAnIncompleteFrame) {
    expect_a_pause_ends_a_frame(make<Ibus2Decoder>, from_hex(kCaptured8), from_hex(kCaptured8));
}

TEST(Ibus2Decoder, FindsTheSameHoweverTheStreamIsCutIntoReads) {
    Bytes bytes = plain_ibus2_key(Types(8, kUsualType));
    append(bytes, four_cycles());
    expect_the_same_however_cut(make<Ibus2Decoder>, bytes, 4);
}

/// A line of all kinds of frames, with noise.
Bytes random_line(Random& random) {
    constexpr std::array<std::uint8_t, 8> kLikely{0x00, 0x04, 0x05, 0x06, 0x07, 0x0F, 0x18, 0xC0};
    Bytes bytes;
    Types types;
    while (bytes.size() < 400) {
        switch (random.below(7)) {
            case 0:
                bytes.push_back(random.byte());
                break;
            case 1:
                bytes.push_back(kLikely[random.below(kLikely.size())]);
                break;
            case 2:
                append(bytes, from_hex(kReply));
                break;
            case 3:
                types.resize(random.below(20));
                for (unsigned& type : types) {
                    type = random.below(3) == 0 ? random.below(32) : kUsualType;
                }
                append(bytes, plain_ibus2_key(types));
                break;
            default: {
                std::vector<int> values(types.size());
                for (int& value : values) {
                    value = static_cast<int>(random());
                }
                Bytes channels = plain_ibus2_channels(
                    types, values, static_cast<std::uint8_t>(random.below(4) << 6U));
                if (channels.size() <= 37) {
                    append(bytes, channels);
                }
            }
        }
    }
    return bytes;
}

TEST(Ibus2Decoder, FindsWhatThePlainFormFindsOnAnyLine) {
    std::size_t channels_seen = 0;
    for (std::uint32_t seed = 1; seed <= 800; ++seed) {
        Random random(seed);
        Bytes bytes = random_line(random);
        for (std::uint32_t fault = 0; fault < seed % 4; ++fault) {
            bytes[random.below(400)] = random.byte();
        }
        Ibus2Decoder decoder;
        const auto frames = all_frames(decoder, bytes, {.longest = 40, .seed = seed});
        const auto plain = PlainIbus2().frames_of(bytes);
        ASSERT_EQ(frames.size(), plain.size()) << seed;
        for (std::size_t i = 0; i < frames.size(); ++i) {
            ASSERT_EQ(frames[i].first_byte, plain[i].at) << seed;
            ASSERT_EQ(frames[i].length, plain[i].length) << seed;
            ASSERT_EQ(frames[i].channels.frame_lost, plain[i].frame_lost) << seed;
            ASSERT_EQ(frames[i].channels.failsafe, plain[i].failsafe) << seed;
            const auto us = microseconds(frames[i].channels, kChannelCount);
            for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
                ASSERT_EQ(us[channel], plain[i].us[channel]) << seed << " " << channel;
                channels_seen += us[channel] ? 1U : 0U;
            }
        }
    }
    EXPECT_GT(channels_seen, 10000U);
}

}  // namespace
}  // namespace tribus::test::ibus2_stream_test
