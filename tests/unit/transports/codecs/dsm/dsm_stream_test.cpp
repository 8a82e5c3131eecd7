#include "transports/codecs/dsm/dsm.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/plain_dsm.h"
#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/dsm/dsm_lines.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/sbus/sbus.h"

namespace tribus::test::dsm_stream_test {
namespace {

using namespace dsm_lines;

/// Frames without pauses, with sticks that move.
FrameStream moving(std::uint32_t seed, std::size_t count, std::uint8_t system = 0xB2) {
    Random random(seed);
    FrameStream stream;
    for (std::size_t i = 0; i < count; ++i) {
        const auto value = [&] { return 300 + random.below(1400); };
        stream.add_frame(
            i % 2 == 0 ? frame_of({static_cast<std::uint16_t>(0x8000U | word_of(1, value())),
                                   word_of(5, value()), word_of(2, value()), word_of(3, value()),
                                   word_of(0, value()), word_of(7, value()), word_of(6, value())},
                                  system)
                       : frame_of({word_of(1, value()), word_of(5, value()), word_of(2, value()),
                                   word_of(3, value()), word_of(4, value()), word_of(8, value()),
                                   word_of(9, value())},
                                  system));
    }
    return stream;
}

TEST(DsmWithoutPauses, IsFoundByContentFromTheFourthFrameOn) {
    for (std::size_t noise = 0; noise < 40; ++noise) {
        Bytes bytes(noise, 0x3D);
        const FrameStream stream = moving(1, 20);
        append(bytes, stream.bytes);
        DsmDecoder decoder;
        const auto frames = feed(decoder, bytes);
        ASSERT_EQ(frames.size(), 17U) << noise;
        for (std::size_t i = 0; i < frames.size(); ++i) {
            EXPECT_EQ(frames[i].first_byte, noise + 16 * (i + 3));
        }
        EXPECT_EQ(decoder.skipped_bytes(), noise);
    }
}

TEST(DsmWithoutPauses, EveryFaultEndsInTheRightPlaceAgain) {
    constexpr std::size_t kFrames = 30;
    const FrameStream stream = moving(2, kFrames);
    for (const FaultKind kind :
         {FaultKind::lost, FaultKind::added, FaultKind::replaced, FaultKind::damaged}) {
        for (std::size_t at = 0; at < 16 * 12; ++at) {
            const Fault fault{kind, at, 0x7F};
            DsmDecoder decoder;
            const auto frames = feed(decoder, stream.bytes, fault, {.longest = 30, .seed = 3});
            ASSERT_FALSE(frames.empty()) << fault;
            EXPECT_GE(frames.size(), kFrames - 13) << fault;
            for (const DecodedFrame& frame : frames) {
                // A frame stands in its place, but for the one that the fault hit near its end.
                const bool in_place = std::ranges::any_of(
                    std::array{frame.first_byte, frame.first_byte + 1},
                    [&](std::uint64_t place) { return place % 16 == 0 || place % 16 == 1; });
                EXPECT_TRUE(in_place) << fault;
                if (frame.first_byte > at + 16) {
                    const std::size_t shift = kind == FaultKind::lost    ? 15
                                              : kind == FaultKind::added ? 1
                                                                         : 0;
                    EXPECT_EQ(frame.first_byte % 16, shift) << fault;
                }
            }
        }
    }
}

TEST(DsmWithoutPauses, NeedsADocumentedSystemByteThatFitsTheResolution) {
    for (unsigned system = 0; system <= 0xFF; ++system) {
        DsmDecoder decoder;
        const auto frames = feed(decoder, moving(3, 12, static_cast<std::uint8_t>(system)).bytes);
        const bool documented = system == 0x12 || system == 0xA2 || system == 0xB2;
        EXPECT_EQ(!frames.empty(), documented) << system;
        Bytes ten_bits;
        for (unsigned i = 0; i < 12; ++i) {
            append(ten_bits, seven(400 + i, 10, static_cast<std::uint8_t>(system)));
        }
        DsmDecoder coarse;
        EXPECT_EQ(!feed(coarse, ten_bits).empty(), system == 0x01) << system;
    }
}

TEST(DsmWithoutPauses, APlaceThatIsNotTheOnlyOneIsNotTaken) {
    // The first word is channel 0 with a value whose low byte is a system byte: one word further,
    // the frames look as right as in their place.
    const Bytes two_places =
        frame_of({word_of(0, 0x1B2), word_of(1, 1024), word_of(2, 1024), word_of(3, 1024),
                  word_of(4, 1024), word_of(5, 1024), word_of(6, 1024)});
    Bytes bytes;
    for (int i = 0; i < 30; ++i) {
        append(bytes, two_places);
    }
    DsmDecoder decoder;
    EXPECT_TRUE(feed(decoder, bytes).empty());
    append(bytes, moving(4, 10).bytes);
    DsmDecoder moved;
    const auto frames = feed(moved, bytes);
    ASSERT_FALSE(frames.empty());
    EXPECT_EQ(frames[0].first_byte % 16, 0U);
    PausedLine line;
    line.hear(two_places);
    line.hear(two_places);
    EXPECT_EQ(us(line.hear(two_places), 0), exact_eighths(DsmScale::spektrum, 0x1B2, 11) / 8.0)
        << "a pause tells the place";
}
TEST(DsmDecoder, TakesNoOtherProtocolForIts) {
    Random random(5);
    ChannelFrame channels;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        channels.set(channel, kCentrePulse);
    }
    IbusEncoder ibus(14);
    SbusEncoder sbus;
    for (int run = 0; run < 300; ++run) {
        DsmDecoder without_pauses;
        PausedLine line;
        std::size_t frames = 0;
        for (int i = 0; i < 60; ++i) {
            std::array<std::uint8_t, kLongestSerialFrame> wire{};
            for (std::size_t channel = 0; channel < 14 && i % 6 == 0; ++channel) {
                channels.set(channel, Pulse::from_microseconds(1000 + random.below(1000)));
            }
            std::size_t length = 1 + random.below(40);
            if (run % 3 == 0) {
                length = ibus.write(channels, wire, {});
            } else if (run % 3 == 1) {
                length = sbus.write(channels, wire, {});
            } else {
                std::ranges::generate(wire, [&] { return random.byte(); });
            }
            const Bytes bytes(wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length));
            line.hear(bytes);
            frames += feed(without_pauses, bytes).size();
        }
        EXPECT_EQ(frames, 0U) << run;
        EXPECT_EQ(line.frames(), 0U) << run;
    }
}

/// A line with faults, pauses, stalls and silences.
std::vector<reference::PlainDsmRead> some_line(std::uint32_t seed) {
    Random random(seed);
    const bool ten_bits = seed % 5 == 0;
    const bool pauses = seed % 3 != 0;
    const FrameStream stream = moving(seed, 40);
    std::vector<reference::PlainDsmRead> reads;
    double now = 1000;
    for (std::size_t i = 0; i < stream.starts.size(); ++i) {
        const auto frame = std::span(stream.bytes).subspan(16 * i, 16);
        Bytes bytes =
            ten_bits ? seven(random.below(1024), 10, 0x01) : Bytes(frame.begin(), frame.end());
        if (random.below(12) == 0 && !ten_bits) {
            bytes = from_hex("01B20C002956140025F83400E000E00A");
        }
        if (random.below(8) == 0) {
            constexpr std::array kKinds{FaultKind::lost, FaultKind::added, FaultKind::replaced};
            bytes = with_fault(std::move(bytes),
                               {kKinds[random.below(3)], random.below(16), random.byte()});
        }
        if (random.below(25) == 0) {
            Bytes more(random.below(20));
            std::ranges::generate(more, [&] { return random.byte(); });
            append(bytes, more);
        }
        now += random.below(20) == 0 ? 50 + random.below(100) : 11;
        const bool paused = pauses && random.below(6) != 0;
        const std::size_t cut = random.below(static_cast<std::uint32_t>(bytes.size() + 1));
        const auto middle = bytes.begin() + static_cast<std::ptrdiff_t>(cut);
        reads.push_back({{bytes.begin(), middle}, paused, now});
        reads.push_back({{middle, bytes.end()}, pauses && random.below(40) == 0, now + 1});
    }
    return reads;
}

TEST(DsmDecoder, FindsWhatThePlainFormFindsOnAnyLine) {
    std::size_t all = 0;
    for (std::uint32_t seed = 1; seed <= 600; ++seed) {
        const auto reads = some_line(seed);
        const unsigned bits = seed % 7 == 0 ? 11 : seed % 11 == 0 ? 10 : 0;
        DsmDecoder decoder(DsmScale::betaflight, bits == 11   ? DsmResolution::bits_11
                                                 : bits == 10 ? DsmResolution::bits_10
                                                              : DsmResolution::either);
        std::vector<DecodedFrame> found;
        for (const auto& read : reads) {
            DecodedFrame late;
            while (read.pause_before && decoder.silence(late)) {
                found.push_back(late);
            }
            const auto at = Instant(std::chrono::milliseconds(static_cast<int>(read.at)));
            feed_into(found, decoder, read.bytes, {.longest = 20, .seed = seed}, at);
        }
        const auto expected = reference::PlainDsm(bits).frames_of(reads);
        ASSERT_EQ(found.size(), expected.size()) << seed;
        for (std::size_t i = 0; i < found.size(); ++i) {
            ASSERT_EQ(found[i].first_byte, expected[i].at) << seed;
            for (unsigned channel = 0; channel < kChannelCount; ++channel) {
                const auto value = expected[i].values.find(channel);
                const auto pulse = found[i].channels.channel(channel);
                ASSERT_EQ(pulse.has_value(), value != expected[i].values.end()) << seed;
                ASSERT_TRUE(!pulse || pulse->eighths() ==
                                          exact_eighths(DsmScale::betaflight, value->second, 11))
                    << seed;
            }
        }
        all += found.size();
    }
    EXPECT_GT(all, 6000U);
}

TEST(DsmDecoder, FindsTheSameFramesHoweverReadsCutTheStream) {
    Bytes bytes = moving(6, 60).bytes;
    for (const std::size_t at : {200U, 400U, 600U}) {
        bytes = with_fault(std::move(bytes), {FaultKind::lost, at, 0});
    }
    DsmDecoder whole;
    const auto expected = feed(whole, bytes);
    EXPECT_GT(expected.size(), 30U);
    for (std::uint32_t seed = 0; seed < 60; ++seed) {
        DsmDecoder decoder;
        const Split split = seed == 0 ? kByteByByte : Split{.longest = 2 * seed, .seed = seed};
        EXPECT_TRUE(same_frames(feed(decoder, bytes, split), expected)) << seed;
        EXPECT_EQ(decoder.skipped_bytes(), whole.skipped_bytes()) << seed;
    }
    for (std::size_t cut = 1; cut < 16; ++cut) {
        PausedLine line;
        for (int i = 0; i < 6; ++i) {
            const auto frame = line.hear(seven(1024), 11ms, {.longest = cut});
            EXPECT_EQ(frame.has_value(), i >= 2) << cut;
        }
    }
}

TEST(DsmDecoder, SeveralFramesMayFollowWithoutAPause) {
    PausedLine line;
    line.hear(kPhaseA);
    line.hear(kPhaseB);
    Bytes late = from_hex(kPhaseA);
    append(late, from_hex(kPhaseB));
    append(late, from_hex(kPhaseA));
    line.hear(late, 33ms);
    EXPECT_EQ(line.frames(), 2U);
}

TEST(DsmDecoder, NoFrameHasADamagedByte) {
    for (std::uint32_t seed = 1; seed <= 60; ++seed) {
        DsmDecoder decoder;
        Random random(seed);
        expect_no_frame_over_damage(decoder, moving(seed, 60).bytes, random, 600);
    }
    PausedLine line;
    for (int i = 0; i < 3; ++i) {
        line.hear(seven(1024));
    }
    line.hear(Bytes{0x00, 0xB2});
    line.decoder().damaged_byte();
    std::vector<DecodedFrame> frames;
    const Bytes whole = seven(1024);
    feed_into(frames, line.decoder(), std::span(whole).subspan(3));
    EXPECT_TRUE(frames.empty());
    EXPECT_EQ(count_of(line.decoder(), "damaged"), 1U);
    EXPECT_TRUE(line.hear(seven(1024))) << "the damaged frame is known to be wrong, others are not";
}

TEST(DsmDecoder, AnotherLineNeedsItsOwnProof) {
    PausedLine line;
    for (int i = 0; i < 3; ++i) {
        line.hear(seven(1024));
    }
    line.decoder().reset();
    EXPECT_FALSE(line.hear(seven(1024)));
    EXPECT_FALSE(line.hear(seven(1024)));
    EXPECT_TRUE(line.hear(seven(1024)));
}

}  // namespace
}  // namespace tribus::test::dsm_stream_test
