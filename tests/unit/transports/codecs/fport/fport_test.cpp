#include "transports/codecs/fport/fport.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/stream_rules.h"
#include "tests/unit/transports/codecs/fport/fport_frames.h"

namespace tribus::test::fport_test {
namespace {

using namespace fport_frames;

class FportFormats : public testing::TestWithParam<Format> {
  protected:
    const Format& format() const { return GetParam(); }
    Bytes four_frames() const {
        Bytes bytes;
        for (std::uint16_t i = 0; i < 4; ++i) {
            append(bytes, format().channels(some(static_cast<std::uint16_t>(700 + 37 * i)), 0, 50));
            append(bytes, format().telemetry());
        }
        return bytes;
    }
    /// Compares with the plain form, all values.
    void expect_as_plain(const Bytes& bytes, Split split, std::uint32_t seed) const {
        const auto decoder = format().decoder();
        const auto frames = all_frames(*decoder, bytes, split);
        auto plain = format().plain(bytes);
        std::erase_if(plain, [](const auto& frame) { return !frame.has_channels; });
        ASSERT_EQ(frames.size(), plain.size()) << seed;
        for (std::size_t i = 0; i < frames.size(); ++i) {
            ASSERT_EQ(frames[i].first_byte, plain[i].at) << seed;
            ASSERT_EQ(frames[i].length, plain[i].length) << seed;
            ASSERT_EQ(frames[i].channels.frame_lost, (plain[i].flags & 4) != 0) << seed;
            ASSERT_EQ(frames[i].channels.failsafe, (plain[i].flags & 8) != 0) << seed;
            expect_raw(frames[i].channels, plain[i].raw);
        }
    }
};

TEST_P(FportFormats, ReadEveryRawValueOfEveryChannelExactly) {
    for (std::uint16_t raw = 0; raw <= 2047; ++raw) {
        for (const Split split : {kOneRead, kByteByByte}) {
            const auto decoder = format().decoder();
            const auto frames = feed(*decoder, format().channels(some(raw), 0, 60), split);
            ASSERT_EQ(frames.size(), 1U) << raw;
            expect_raw(frames[0].channels, some(raw));
            ASSERT_TRUE(frames[0].channels.good());
        }
    }
}

TEST_P(FportFormats, ReadFrameLostAndFailsafeAndNoSwitches) {
    for (unsigned flags = 0; flags <= 0xFF; ++flags) {
        const auto decoder = format().decoder();
        const auto frames =
            feed(*decoder, format().channels(some(992), static_cast<std::uint8_t>(flags), 60));
        ASSERT_EQ(frames.size(), 1U) << flags;
        EXPECT_EQ(frames[0].channels.frame_lost, (flags & 4) != 0);
        EXPECT_EQ(frames[0].channels.failsafe, (flags & 8) != 0);
        EXPECT_FALSE(frames[0].channels.has(16));
        EXPECT_FALSE(frames[0].channels.has(17));
    }
}

TEST_P(FportFormats, AFrameAfterABadLinkHasItsOwnFlags) {
    const auto decoder = format().decoder();
    Bytes bytes = format().channels(some(992), 0x0C, 60);
    append(bytes, format().channels(some(992), 0x00, 60));
    const auto frames = feed(*decoder, bytes);
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_FALSE(frames[0].channels.good());
    EXPECT_TRUE(frames[1].channels.good());
}

TEST_P(FportFormats, RawValuesAndRssiAreDetails) {
    const auto decoder = format().decoder();
    EXPECT_TRUE(decoder->details().empty());
    feed(*decoder, format().channels(some(5), 0, 77));
    const auto details = decoder->details();
    ASSERT_EQ(details.size(), 2U);
    EXPECT_EQ(details[0].name, "raw");
    EXPECT_EQ(Raw(details[0].values.begin(), details[0].values.end()), some(5));
    EXPECT_EQ(details[1].name, "rssi");
    EXPECT_EQ(details[1].values[0], 77);
    EXPECT_EQ(decoder->radio_statistics(), nullptr);
}

TEST_P(FportFormats, PassOverTelemetryWithoutARejection) {
    for (const Split split : {kOneRead, kByteByByte}) {
        const auto decoder = format().decoder();
        const auto frames = all_frames(*decoder, four_frames(), split);
        EXPECT_EQ(frames.size(), 4U);
        EXPECT_EQ(decoder->skipped_bytes(), 0U);
        EXPECT_EQ(count_of(*decoder, "checksum"), 0U);
    }
}

TEST_P(FportFormats, RefuseEachFlippedBitAndReadTheNextFrame) {
    expect_each_flipped_bit_is_refused(format().decoder, format().channels(some(700), 0, 60),
                                       format().channels(some(900), 0, 60));
}

TEST_P(FportFormats, LoseOneFrameAtMostByAByteThatIsLostOrAddedAnywhere) {
    const Bytes good = four_frames();
    for (std::size_t at = 0; at < good.size(); ++at) {
        std::vector<Fault> faults{{FaultKind::lost, at}, {FaultKind::damaged, at}};
        for (const std::uint8_t value : Bytes{0x00, 0x08, 0x18, 0x19, 0x7D, 0x7E, 0xFF}) {
            faults.push_back({FaultKind::added, at, value});
        }
        for (const Fault& fault : faults) {
            for (const Split split : {kOneRead, kByteByByte}) {
                const auto decoder = format().decoder();
                const auto frames = all_frames(*decoder, good, split, fault);
                EXPECT_GE(frames.size(), 3U) << fault;
                EXPECT_LE(frames.size(), 4U) << fault;
            }
        }
    }
}

TEST_P(FportFormats, FindAFrameBehindAnyFalseBeginning) {
    const Bytes whole = format().channels(some(700), 0, 60);
    for (std::size_t cut = 1; cut < whole.size(); ++cut) {
        if (whole[cut] == 0x7E) {
            continue;  // TheFirstMarkerOfTheNextFrameMayEndAFrame
        }
        Bytes bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut));
        append(bytes, format().channels(some(900), 0, 60));
        for (const Split split : {kOneRead, kByteByByte}) {
            const auto decoder = format().decoder();
            const auto frames = all_frames(*decoder, bytes, split);
            ASSERT_EQ(frames.size(), 1U) << cut;
            EXPECT_EQ(frames[0].first_byte, cut);
        }
    }
}

TEST_P(FportFormats, APauseEndsAnIncompleteFrame) {
    expect_a_pause_ends_a_frame(format().decoder, format().channels(some(700), 0, 60),
                                format().channels(some(900), 0, 60));
}

TEST_P(FportFormats, FindTheSameHoweverTheStreamIsCutIntoReads) {
    expect_the_same_however_cut(format().decoder, four_frames(), 4);
}

TEST_P(FportFormats, FindWhatThePlainFormFindsOnAnyLine) {
    constexpr std::array<std::uint8_t, 8> kLikely{0x08, 0x0D, 0x18, 0x19, 0x23, 0x7D, 0x7E, 0xFF};
    for (std::uint32_t seed = 1; seed <= 600; ++seed) {
        Random random(seed);
        Bytes bytes;
        while (bytes.size() < 400) {
            const std::uint32_t kind = random.below(6);
            if (kind == 0) {
                bytes.push_back(random.byte());
            } else if (kind == 1) {
                bytes.push_back(kLikely[random.below(kLikely.size())]);
            } else if (kind == 2) {
                append(bytes, format().telemetry());
            } else {
                Raw raw(16);
                for (std::uint16_t& value : raw) {
                    value = static_cast<std::uint16_t>(random.below(2048));
                }
                append(bytes, format().channels(raw, random.byte(), random.byte()));
            }
        }
        for (std::uint32_t fault = 0; fault < seed % 4; ++fault) {
            bytes[random.below(400)] =
                seed % 3 == 0 ? random.byte() : kLikely[random.below(kLikely.size())];
        }
        expect_as_plain(bytes, {.longest = 40, .seed = seed}, seed);
        expect_as_plain(bytes, kOneRead, seed);
    }
}

INSTANTIATE_TEST_SUITE_P(Fport, FportFormats, testing::Values(kVersion1, kVersion2),
                         [](const auto& format) { return std::string(format.param.name); });

}  // namespace
}  // namespace tribus::test::fport_test
