#include "transports/codecs/sbus/sbus24.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/sbus_frames.h"
#include "tests/support/streams.h"
#include "transports/codecs/sbus/sbus.h"

/// FrSky's frames of 24 channels (docs/protocols/sbus.md, "24 channels").
namespace tribus::test::sbus24_test {
namespace {

using Channels = std::array<unsigned, 24>;

/// A bit at a time.
Bytes frame_of(const Channels& channels, std::uint8_t flags = 0) {
    Bytes bytes(kSbus24FrameLength);
    bytes.front() = 0x0F;
    for (std::size_t bit = 0; bit < 24 * 11; ++bit) {
        const unsigned value = channels[bit / 11] >> bit % 11 & 1U;
        bytes[1 + bit / 8] = static_cast<std::uint8_t>(bytes[1 + bit / 8] | value << bit % 8);
    }
    bytes[34] = flags;
    return bytes;
}

Channels random_channels(Random& random) {
    Channels channels{};
    std::ranges::generate(channels, [&] { return random.below(2048); });
    return channels;
}

/// The frames that a decoder finds in bursts with a pause before each but the first, and one behind
/// the last.
std::vector<DecodedFrame> between_pauses(const std::vector<Bytes>& bursts) {
    SbusDecoder decoder;
    std::vector<DecodedFrame> frames;
    const auto pause = [&] {
        DecodedFrame frame;
        while (decoder.silence(frame)) {
            frames.push_back(frame);
        }
    };
    for (const Bytes& burst : bursts) {
        feed_into(frames, decoder, burst);
        pause();
    }
    return frames;
}

TEST(Sbus24, IsKnownByTwoFramesInARow) {
    Channels centred;
    centred.fill(992);
    ASSERT_EQ(frame_of(centred), from_hex(kCentred24));
    Sbus24Watch watch;
    watch.take(from_hex(kCentred24));
    EXPECT_EQ(watch.frames(), 0U);
    watch.take(from_hex(kCentred24));
    EXPECT_EQ(watch.frames(), 2U);
    watch.take(from_hex(kCentred24));
    EXPECT_EQ(watch.frames(), 3U);
    Sbus24Watch other;
    for (int frame = 0; frame < 100; ++frame) {
        other.take(from_hex(kAll992));
        other.take(from_hex(kHundreds));
    }
    EXPECT_EQ(other.frames(), 0U);
}

/// Channels 17 and 18 stand where flags and footer are: with these values all is allowed there.
TEST(Sbus24, IsNeverReadAsAFrameOf16) {
    for (unsigned seventeen = 0; seventeen < 2048; ++seventeen) {
        Random random(seventeen + 1);
        std::vector<Bytes> bursts;
        for (int frame = 0; frame < 20; ++frame) {
            Channels channels = random_channels(random);
            channels[16] = seventeen;
            channels[17] &= 0x7FEU;
            bursts.push_back(frame_of(channels, frame % 4 == 0 ? 0x0C : 0x00));
        }
        EXPECT_TRUE(between_pauses(bursts).empty()) << seventeen;
    }
}

/// No pulses: FrSky's receivers send zeros.
TEST(Sbus24, IsNeverReadAsAFrameOf16WhereverTheReadingBegins) {
    for (std::size_t begin = 0; begin < kSbus24FrameLength; ++begin) {
        std::vector<Bytes> bursts(20, frame_of({}, 0x0C));
        bursts[0].erase(bursts[0].begin(), bursts[0].begin() + static_cast<std::ptrdiff_t>(begin));
        EXPECT_TRUE(between_pauses(bursts).empty()) << begin;
    }
}

/// No pulses: FrSky's receivers send zeros, so flags and footer of 16 stand wherever the frame is
/// cut.
TEST(Sbus24, IsNeverReadAsAFrameOf16WhereTheLineLosesBytes) {
    const auto cut = [](std::size_t at, std::size_t lost) {
        Bytes bytes = frame_of({}, 0x0C);
        const auto from = bytes.begin() + static_cast<std::ptrdiff_t>(at);
        bytes.erase(from, from + static_cast<std::ptrdiff_t>(lost));
        return bytes;
    };
    for (std::size_t lost = 1; lost <= 10; ++lost) {
        for (std::size_t at = 0; at + lost <= kSbus24FrameLength; ++at) {
            std::vector<Bytes> bursts{{}};
            for (int frame = 0; frame < 10; ++frame) {
                bursts.push_back(cut(at, lost));
                bursts.push_back(frame_of({}, 0x0C));
            }
            ASSERT_TRUE(between_pauses(bursts).empty()) << lost << " lost at " << at;
        }
    }
}

/// The byte before the pause is one too many, so that more than a frame waits.
TEST(Sbus24, IsNeverReadAsAFrameOf16WhereTheLineAddsBytes) {
    for (const std::uint8_t added : from_hex("00 0f ff")) {
        for (std::ptrdiff_t at = 0; at <= static_cast<std::ptrdiff_t>(kSbus24FrameLength); ++at) {
            Bytes more = frame_of({}, 0x0C);
            more.insert(more.begin() + at, added);
            const std::vector<Bytes> bursts{{}, more, frame_of({}, 0x0C), more, more, more};
            ASSERT_TRUE(between_pauses(bursts).empty()) << unsigned{added} << " at " << at;
        }
    }
}

/// A machine that was late reads several at once.
TEST(Sbus24, IsNeverReadAsAFrameOf16WhenSeveralComeAtOnce) {
    Bytes several;
    for (int frame = 0; frame < 3; ++frame) {
        append(several, frame_of({}, 0x0C));
    }
    EXPECT_TRUE(between_pauses({several, several, several}).empty());
}

TEST(Sbus24, NoEndOfAStreamOf16IsTakenForIt) {
    Bytes stream;
    for (int frame = 1; frame <= 80; ++frame) {
        append(stream, from_hex(kHundreds));
        SbusDecoder decoder;
        const std::size_t found = feed(decoder, stream).size();
        EXPECT_EQ(found + (decoder.finish() ? 1 : 0), static_cast<std::size_t>(frame));
        EXPECT_EQ(between_pauses({stream}).size(), static_cast<std::size_t>(frame));
    }
}

TEST(Sbus24, IsNamedByTheDecoderWhileTheLineHasIt) {
    SbusDecoder decoder;
    const auto fault = [&decoder] {
        std::array<char, 160> text{};
        return std::string(text.data(), decoder.write_fault(text));
    };
    const auto hear = [&decoder](const Bytes& burst) {
        feed(decoder, burst);
        DecodedFrame frame;
        while (decoder.silence(frame)) {
        }
    };
    EXPECT_EQ(fault(), "");
    hear(frame_of({}));
    EXPECT_EQ(fault(), kSbus24Text);
    hear(from_hex(kHundreds));
    hear(from_hex(kHundreds));
    EXPECT_EQ(fault(), "");
}

TEST(Sbus24, FramesOf16CountAgainWhenTheReceiverIsSetToThem) {
    std::vector<Bytes> bursts(5, frame_of({}));
    for (int frame = 0; frame < 10; ++frame) {
        bursts.push_back(from_hex(kHundreds));
    }
    EXPECT_EQ(between_pauses(bursts).size(), 10U);
}

}  // namespace
}  // namespace tribus::test::sbus24_test
