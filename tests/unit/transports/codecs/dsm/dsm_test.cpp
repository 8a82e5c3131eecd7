#include "transports/codecs/dsm/dsm.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "app/doctor/line_judge.h"
#include "tests/reference/plain_dsm.h"
#include "tests/support/streams.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/registry/registry.h"

namespace tribus::test::dsm_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant kStart = Instant(1h);
constexpr std::uint16_t kUnused = 0xFFFF;

// ArduPilot, RCProtocolTest.cpp: a receiver's two phases of 11 bits (dsm2), one frame of 10 bits
// (dsm5), two phases of which the first has settings of a video transmitter now and then
// (dsmx22_vtx).
constexpr std::string_view kPhaseA = "00B280943C021BFE44004C005C00FFFF";
constexpr std::string_view kPhaseB = "00B20C032EAA1400215634025400FFFF";
constexpr std::string_view kTenBits = "03B205FE1755135509FC18AB00560DFD";
constexpr std::string_view kBeforeVtx = "00B20C002956140025F834005400FFFF";
constexpr std::string_view kOtherPhase = "00B281503C001BFD44004C005C00FFFF";
constexpr std::string_view kVtx = "00B20C002956140025F83400E000E00A";

Bytes frame_of(const std::vector<std::uint16_t>& words, std::uint8_t system = 0xB2) {
    Bytes bytes{0x00, system};
    for (std::size_t i = 0; i < 7; ++i) {
        const std::uint16_t word = i < words.size() ? words[i] : kUnused;
        bytes.push_back(static_cast<std::uint8_t>(word >> 8U));
        bytes.push_back(static_cast<std::uint8_t>(word));
    }
    return bytes;
}

std::uint16_t word_of(unsigned channel, unsigned value, unsigned bits = 11) {
    return static_cast<std::uint16_t>(channel << bits | value);
}

/// Seven channels with this value.
Bytes seven(unsigned value, unsigned bits = 11, std::uint8_t system = 0xB2) {
    std::vector<std::uint16_t> words;
    for (const unsigned channel : {1U, 5U, 2U, 3U, 0U, 4U, 6U}) {
        words.push_back(word_of(channel, value, bits));
    }
    return frame_of(words, system);
}

/// A line with a pause before each burst.
class PausedLine {
  public:
    explicit PausedLine(DsmScale scale = DsmScale::spektrum,
                        DsmResolution resolution = DsmResolution::either)
        : decoder_(scale, resolution) {}

    /// Returns the last frame that counts, if any.
    std::optional<ChannelFrame> hear(const Bytes& bytes, Duration after = 11ms,
                                     Split split = kOneRead) {
        now_ += after;
        DecodedFrame late;
        EXPECT_FALSE(decoder_.silence(late));
        std::vector<DecodedFrame> frames;
        feed_into(frames, decoder_, bytes, split, now_);
        frames_ += frames.size();
        return frames.empty() ? std::nullopt : std::optional(frames.back().channels);
    }
    std::optional<ChannelFrame> hear(std::string_view hex, Duration after = 11ms) {
        return hear(from_hex(hex), after);
    }
    DsmDecoder& decoder() { return decoder_; }
    Instant now() const { return now_; }
    std::size_t frames() const { return frames_; }

  private:
    DsmDecoder decoder_;
    Instant now_ = kStart;
    std::size_t frames_ = 0;
};

double us(const std::optional<ChannelFrame>& frame, std::size_t channel) {
    return frame ? frame->channel_or(channel, Pulse{}).microseconds() : -1;
}

/// Rounded to the nearest eighth.
int exact_eighths(DsmScale scale, unsigned value, unsigned bits) {
    const double fine = bits == 10 ? 2.0 * value : value;
    const double exact = scale == DsmScale::spektrum ? (fine - 1024) / 1.7 + 1500 : fine / 2 + 988;
    return static_cast<int>(std::floor(exact * 8 + 0.5));
}

TEST(DsmDecoder, ReadsEveryValueOfEveryChannelInBothScales) {
    for (const DsmScale scale : {DsmScale::spektrum, DsmScale::betaflight}) {
        PausedLine fine(scale);
        PausedLine coarse(scale);
        for (unsigned value = 0; value < 2048 + 3; ++value) {
            const auto frame = fine.hear(seven(value % 2048));
            const auto ten = coarse.hear(seven(value % 1024, 10, 0x01));
            if (value < 2) {
                EXPECT_FALSE(frame || ten);
                continue;
            }
            ASSERT_TRUE(frame && ten) << value;
            for (std::size_t channel = 0; channel < 7; ++channel) {
                ASSERT_EQ(frame->channel(channel)->eighths(),
                          exact_eighths(scale, value % 2048, 11))
                    << value;
                ASSERT_EQ(ten->channel(channel)->eighths(), exact_eighths(scale, value % 1024, 10))
                    << value;
            }
            ASSERT_FALSE(frame->has(7));
            ASSERT_TRUE(frame->good());
        }
    }
}

TEST(DsmDecoder, ReadsTwoPhases) {
    PausedLine line;
    std::optional<ChannelFrame> frame;
    for (const auto hex : {kPhaseA, kPhaseB, kPhaseA, kPhaseB}) {
        EXPECT_FALSE(frame);
        frame = line.hear(hex);
    }
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->received, line.now());
    EXPECT_EQ(us(frame, 0), 984.75) << "throttle";
    EXPECT_EQ(us(frame, 1), 1501.75);
    EXPECT_EQ(us(frame, 5), 1901.125);
    EXPECT_EQ(us(frame, 11), 1500);
    EXPECT_EQ(frame->absent(), kAllChannels & ~first_channels(12));
    EXPECT_EQ(count_of(line.decoder(), "unproven"), 3U);
    EXPECT_EQ(line.decoder().skipped_bytes(), 0U);
}

TEST(DsmDecoder, ReadsAFrameOf10Bits) {
    PausedLine line;
    line.hear(kTenBits);
    line.hear(kTenBits);
    const auto frame = line.hear(kTenBits);
    ASSERT_TRUE(frame);
    EXPECT_EQ(us(frame, 1), 1497.625);
    EXPECT_EQ(us(frame, 4), 1901.125);
    EXPECT_EQ(us(frame, 0), 998.875);
}

TEST(DsmDecoder, NoFrameCountsBeforeTwoHaveAgreed) {
    PausedLine line;
    EXPECT_FALSE(line.hear(seven(1000)));
    EXPECT_FALSE(line.hear(seven(1100)));
    EXPECT_TRUE(line.hear(seven(1200)));
    EXPECT_TRUE(line.hear(seven(300))) << "values may change at will";
}

TEST(DsmDecoder, NoFrameCountsWithoutThePrimaryChannels) {
    for (unsigned missing = 0; missing < 4; ++missing) {
        std::vector<std::uint16_t> words;
        for (unsigned channel = 0; channel < 8; ++channel) {
            if (channel != missing) {
                words.push_back(word_of(channel, 1024));
            }
        }
        PausedLine line;
        for (int i = 0; i < 20; ++i) {
            EXPECT_FALSE(line.hear(frame_of(words))) << missing;
        }
    }
}

TEST(DsmDecoder, ALongerSilenceNeedsTheWholeProofAgain) {
    for (const Duration silence : {100ms, 101ms}) {
        PausedLine line;
        for (int i = 0; i < 4; ++i) {
            line.hear(i % 2 == 0 ? kPhaseA : kPhaseB);
        }
        const bool kept = silence == 100ms;
        EXPECT_EQ(line.hear(kPhaseA, silence).has_value(), kept);
        EXPECT_EQ(line.hear(kPhaseB).has_value(), kept);
        EXPECT_EQ(line.hear(kPhaseA).has_value(), kept);
        EXPECT_TRUE(line.hear(kPhaseB));
    }
}

TEST(DsmDecoder, EachBreakNeedsTwoAgreeingFramesAgain) {
    Bytes twice = from_hex(kPhaseA);
    twice[12] = 0x3C;  // channel 7 again
    const Bytes cut = [] {
        Bytes bytes = from_hex(kPhaseA);
        bytes.pop_back();
        return bytes;
    }();
    Bytes long_one = from_hex(kPhaseA);
    long_one.push_back(0x00);
    for (const Bytes& wrong : {twice, cut, Bytes{0x00}, seven(1024), Bytes(16, 0xFF)}) {
        PausedLine line;
        for (int i = 0; i < 4; ++i) {
            line.hear(i % 2 == 0 ? kPhaseA : kPhaseB);
        }
        EXPECT_FALSE(line.hear(wrong)) << wrong.size();
        EXPECT_FALSE(line.hear(kPhaseB)) << wrong.size();
        const auto frame = line.hear(kPhaseA);
        ASSERT_TRUE(frame) << wrong.size();
        EXPECT_EQ(us(frame, 1), 1501.75);
    }
    // Only the pause after a frame shows that it was too long.
    PausedLine line;
    for (int i = 0; i < 4; ++i) {
        line.hear(i % 2 == 0 ? kPhaseA : kPhaseB);
    }
    line.hear(long_one);
    EXPECT_FALSE(line.hear(kPhaseB));
    EXPECT_TRUE(line.hear(kPhaseA));
}

TEST(DsmDecoder, AChannelThatIsNotRenewedBecomesAbsent) {
    PausedLine line;
    for (int i = 0; i < 4; ++i) {
        line.hear(i % 2 == 0 ? kPhaseA : kPhaseB);
    }
    // Phase A, with the throttle, came last 11 ms before.
    const auto still = line.hear(kPhaseB, 89ms);
    ASSERT_TRUE(still);
    EXPECT_TRUE(still->has(0));
    const auto later = line.hear(kPhaseB, 1ms);
    ASSERT_TRUE(later);
    EXPECT_FALSE(later->has(0));
    EXPECT_FALSE(later->has(11));
    EXPECT_TRUE(later->has(1));
    const auto again = line.hear(kPhaseA);
    ASSERT_TRUE(again);
    EXPECT_TRUE(again->has(0));
}

TEST(DsmDecoder, ValuesFromBeforeABreakDoNotComeBack) {
    PausedLine line;
    for (int i = 0; i < 4; ++i) {
        line.hear(i % 2 == 0 ? kPhaseA : kPhaseB);
    }
    line.hear(Bytes{0x00});
    line.hear(kPhaseB);
    EXPECT_FALSE(line.hear(kPhaseB)) << "of the primary channels, phase B has no throttle";
    const auto frame = line.hear(kPhaseA);
    ASSERT_TRUE(frame);
    EXPECT_TRUE(frame->has_first(4));
}

TEST(DsmDecoder, RefusesAChannelTwiceAndNumbersThatAreNone) {
    for (unsigned channel = 0; channel < 32; ++channel) {
        for (std::size_t place = 0; place < 7; ++place) {
            Bytes wrong = seven(1024);
            const std::uint8_t old = wrong[2 + 2 * place] >> 3U;
            wrong[2 + 2 * place] = static_cast<std::uint8_t>(channel << 3U | 4U);
            PausedLine line;
            line.hear(wrong);
            // 16 is the phase, which only the first word has; 12 and 28 belong to X-Plus.
            const unsigned number = place == 0 ? channel % 16 : channel;
            const bool new_number = number > 6 && number < 12;
            const bool extension = place != 0 && (channel == 12 || channel == 28);
            EXPECT_EQ(count_of(line.decoder(), "implausible"),
                      number == old || new_number || extension ? 0U : 1U)
                << channel << " " << place;
        }
    }
}

TEST(DsmDecoder, NoFrameIsPlausibleInBothResolutions) {
    Random random(1);
    int plausible = 0;
    for (int i = 0; i < 2'000'000; ++i) {
        std::array<std::uint8_t, kDsmFrameBytes> wire{};
        for (std::size_t at = 2; at < wire.size(); at += 2) {
            wire[at] = random.byte() & (i % 2 == 0 ? 0x1FU : 0x3FU);
            wire[at + 1] = random.byte();
            if (random.below(4) == 0) {
                wire[at] = wire[at + 1] = 0xFF;
            }
        }
        const bool fine = DsmLayout::of(wire, DsmResolution::bits_11).has_value();
        const bool coarse = DsmLayout::of(wire, DsmResolution::bits_10).has_value();
        ASSERT_FALSE(fine && coarse);
        plausible += fine || coarse ? 1 : 0;
    }
    EXPECT_GT(plausible, 10'000);
}

TEST(DsmDecoder, AConfiguredResolutionRefusesTheOther) {
    const std::array<std::pair<DsmResolution, std::uint64_t>, 3> cases{
        {{DsmResolution::bits_10, 3}, {DsmResolution::bits_11, 0}, {DsmResolution::either, 3}}};
    for (const auto& [resolution, frames] : cases) {
        PausedLine line(DsmScale::spektrum, resolution);
        for (int i = 0; i < 5; ++i) {
            line.hear(kTenBits);
        }
        EXPECT_EQ(line.frames(), frames);
    }
}

TEST(DsmDecoder, SettingsOfAVideoTransmitterAreNoChannels) {
    PausedLine line;
    for (int i = 0; i < 4; ++i) {
        line.hear(i % 2 == 0 ? kBeforeVtx : kOtherPhase);
    }
    const auto frame = line.hear(kVtx);
    ASSERT_TRUE(frame);
    EXPECT_EQ(us(frame, 4), exact_eighths(DsmScale::spektrum, 1528, 11) / 8.0);
    EXPECT_TRUE(frame->has(10)) << "from the phase before";
    EXPECT_FALSE(frame->has(12));
    EXPECT_TRUE(line.hear(kOtherPhase));
    EXPECT_TRUE(line.hear(kBeforeVtx));
}

TEST(DsmDecoder, AFlippedBitIsRefusedOrChangesOneValueOnly) {
    PausedLine expected;
    for (int i = 0; i < 4; ++i) {
        expected.hear(i % 2 == 0 ? kPhaseA : kPhaseB);
    }
    const auto right = expected.hear(kPhaseA);
    ASSERT_TRUE(right);
    for (std::size_t bit = 0; bit < 128; ++bit) {
        Bytes wrong = from_hex(kPhaseA);
        wrong[bit / 8] = static_cast<std::uint8_t>(wrong[bit / 8] ^ (0x80U >> bit % 8));
        PausedLine line;
        for (int i = 0; i < 4; ++i) {
            line.hear(i % 2 == 0 ? kPhaseA : kPhaseB);
        }
        const auto frame = line.hear(wrong);
        const std::size_t in_word = bit % 16;
        const bool header = bit < 16;
        const bool unused = bit >= 112;
        // Five bits of a word say what it is; eleven are its value, which nothing protects.
        // The number 12 is no channel, but may take the place of one: it keeps its value.
        const bool extension = !header && (wrong[bit / 16 * 2] >> 3U & 0xFU) == 12;
        EXPECT_EQ(frame.has_value(), header || extension || (in_word >= 5 && !unused)) << bit;
        std::size_t differences = 0;
        for (std::size_t channel = 0; frame && channel < kChannelCount; ++channel) {
            differences += frame->channel(channel) == right->channel(channel) ? 0U : 1U;
        }
        EXPECT_EQ(differences, frame && !header && !extension ? 1U : 0U) << bit;
        // Two frames later all counts again.
        line.hear(kPhaseB);
        const auto after = line.hear(kPhaseA);
        ASSERT_TRUE(after) << bit;
        EXPECT_TRUE(after->same_content(*right)) << bit;
    }
}

TEST(DsmDecoder, ALostOrAddedByteCostsTheFrameAndTheNextProof) {
    for (std::size_t at = 0; at < 16; ++at) {
        for (const FaultKind kind : {FaultKind::lost, FaultKind::added}) {
            const Fault fault{kind, at, 0x55};
            PausedLine line;
            for (int i = 0; i < 4; ++i) {
                line.hear(i % 2 == 0 ? kPhaseA : kPhaseB);
            }
            const auto hit = line.hear(with_fault(from_hex(kPhaseA), fault));
            // The last word is unused. A byte in the place of a later one shows before the pause
            // only if it changes what a word is.
            EXPECT_FALSE(hit) << fault;
            EXPECT_FALSE(line.hear(kPhaseB)) << fault;
            EXPECT_TRUE(line.hear(kPhaseA)) << fault;
        }
    }
}

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
                    std::array<std::size_t, 2>{frame.first_byte, frame.first_byte + 1},
                    [&](std::size_t place) { return place % 16 == 0 || place % 16 == 1; });
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
            if (read.pause_before && decoder.silence(late)) {
                ADD_FAILURE() << "a pause makes no frame";
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

TEST(DsmDecoder, ShowsHeaderAndWordsOfTheLatestFrame) {
    PausedLine line;
    for (int i = 0; i < 3; ++i) {
        line.hear(kTenBits);
    }
    const auto details = line.decoder().details();
    ASSERT_EQ(details.size(), 3U);
    EXPECT_EQ(details[0].values[0], 0x03);
    EXPECT_EQ(details[1].values[0], 0xB2);
    ASSERT_EQ(details[2].values.size(), 7U);
    EXPECT_EQ(details[2].values[6], 0x0DFD);
}

TEST(DsmProtocol, MakesWhatItsSettingsSay) {
    for (const auto& [scale, pulse] :
         {std::pair("spektrum", 1098.875), std::pair("betaflight", 1159.0)}) {
        SettingValues settings;
        settings.set("scale", std::string(scale));
        settings.set("resolution", std::string("2048"));
        const auto decoder = make_byte_decoder(kDsmProtocol, settings);
        std::vector<DecodedFrame> frames;
        for (int i = 0; i < 3; ++i) {
            DecodedFrame late;
            decoder->silence(late);
            feed_into(frames, *decoder, seven(342));
        }
        ASSERT_EQ(frames.size(), 1U);
        EXPECT_EQ(frames[0].channels.channel(0)->microseconds(), pulse);
        for (int i = 0; i < 3; ++i) {
            DecodedFrame late;
            decoder->silence(late);
            feed_into(frames, *decoder, from_hex(kTenBits));
        }
        EXPECT_EQ(frames.size(), 1U);
    }
}

TEST(Dsm, IsInTheRegistryAsAnInputOnly) {
    EXPECT_EQ(find_protocol("dsm"), &kDsmProtocol);
    EXPECT_FALSE(kDsmProtocol.goes(SettingScope::output));
}

TEST(Dsm, IsHeardByDoctor) {
    doctor::Heard heard{.line = kDsmProtocol.line, .listened = 1s, .bursts = {}};
    for (int i = 0; i < 90; ++i) {
        const Bytes bytes = from_hex(i % 2 == 0 ? kPhaseA : kPhaseB);
        heard.bursts.push_back(
            {.start = i * 11ms, .bytes = bytes, .damaged = std::vector<bool>(bytes.size())});
    }
    const doctor::LineStory story = doctor::judge_line(std::span(&heard, 1));
    EXPECT_EQ(story.protocol, "dsm");
    EXPECT_EQ(story.channels, 12U);
    EXPECT_EQ(story.period, std::optional<Duration>(11ms));
}

}  // namespace
}  // namespace tribus::test::dsm_test
