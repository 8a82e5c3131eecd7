#include "transports/codecs/dsm/dsm.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/heard_line.h"
#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/dsm/dsm_lines.h"
#include "transports/registry/registry.h"

namespace tribus::test::dsm_test {
namespace {

using namespace dsm_lines;

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
    for (const Bytes& wrong : {twice, seven(1024), Bytes(16, 0xFF)}) {
        PausedLine line;
        for (int i = 0; i < 4; ++i) {
            line.hear(i % 2 == 0 ? kPhaseA : kPhaseB);
        }
        EXPECT_FALSE(line.hear(wrong)) << wrong.size();
        EXPECT_FALSE(line.hear(kPhaseB)) << wrong.size();
        EXPECT_FALSE(line.pause()) << wrong.size();
        const auto frame = line.hear(kPhaseA);
        ASSERT_TRUE(frame) << wrong.size();
        EXPECT_EQ(us(frame, 1), 1501.75);
    }
}

TEST(DsmDecoder, ABurstOfAnotherLengthLetsTheNextFrameWaitForItsPause) {
    const Bytes good = from_hex(kPhaseA);
    Bytes long_one = good;
    long_one.push_back(0x00);
    Bytes changed = good;
    changed.insert(changed.begin() + 3, 0x55);
    for (const Bytes& wrong :
         {Bytes(good.begin(), good.end() - 1), Bytes{0x00}, Bytes(15, 0xFF), long_one, changed}) {
        PausedLine line;
        for (int i = 0; i < 4; ++i) {
            line.hear(i % 2 == 0 ? kPhaseA : kPhaseB);
        }
        for (int time = 0; time < 3; ++time) {
            line.hear(wrong);
        }
        EXPECT_FALSE(line.hear(kPhaseB)) << wrong.size();
        const auto shown = line.pause();
        ASSERT_TRUE(shown) << wrong.size();
        EXPECT_TRUE(shown->has_first(4)) << "phase A came less than 100 ms before";
        EXPECT_TRUE(line.hear(kPhaseA)) << wrong.size();
    }
}

TEST(DsmDecoder, AFrameThatWaitsForItsPauseIsNoneIfMoreBytesFollow) {
    PausedLine line;
    for (int i = 0; i < 4; ++i) {
        line.hear(i % 2 == 0 ? kPhaseA : kPhaseB);
    }
    line.hear(Bytes{0x00});
    Bytes added = from_hex(kPhaseA);
    added.insert(added.begin() + 15, 0x55);
    EXPECT_FALSE(line.hear(added));
    EXPECT_FALSE(line.pause());
    EXPECT_FALSE(line.hear(kPhaseA)) << "it waits for its own pause";
    EXPECT_TRUE(line.pause());
}

/// A damaged frame stands between the pause and it.
TEST(DsmDecoder, NoFrameWaitsForItsPauseBehindADamagedOne) {
    PausedLine line;
    for (int i = 0; i < 4; ++i) {
        line.hear(i % 2 == 0 ? kPhaseA : kPhaseB);
    }
    line.hear(Bytes{0x00});
    const Bytes damaged = from_hex(kPhaseA);
    EXPECT_FALSE(line.hear(Bytes(damaged.begin(), damaged.end() - 1)));
    line.decoder().damaged_byte();
    EXPECT_TRUE(feed(line.decoder(), from_hex(kPhaseB), kOneRead, line.now()).empty());
    EXPECT_FALSE(line.pause());
}

TEST(DsmDecoder, NoFrameWaitsForItsPauseAfterALongerSilence) {
    PausedLine line;
    for (int i = 0; i < 4; ++i) {
        line.hear(i % 2 == 0 ? kPhaseA : kPhaseB);
    }
    line.hear(Bytes{0x00});
    EXPECT_FALSE(line.hear(kPhaseA, 101ms));
    EXPECT_FALSE(line.pause());
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
    line.hear(Bytes(16, 0xFF));
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

TEST(DsmDecoder, ALostOrAddedByteCostsOnlyItsFrame) {
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
            EXPECT_TRUE(line.pause()) << fault;
            EXPECT_TRUE(line.hear(kPhaseA)) << fault;
        }
    }
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
    const doctor::LineStory story =
        story_of(kDsmProtocol, {from_hex(kPhaseA), from_hex(kPhaseB)}, 11ms);
    EXPECT_EQ(story.protocol, "dsm");
    EXPECT_EQ(story.channels, 12U);
    EXPECT_EQ(story.period, std::optional<Duration>(11ms));
}

}  // namespace
}  // namespace tribus::test::dsm_test
