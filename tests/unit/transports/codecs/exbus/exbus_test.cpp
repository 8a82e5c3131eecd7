#include "transports/codecs/exbus/exbus.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/reference/plain_exbus.h"
#include "tests/support/heard_line.h"
#include "tests/support/stream_rules.h"
#include "tests/support/streams.h"
#include "transports/codecs/exbus/wire.h"
#include "transports/registry/registry.h"

namespace tribus::test::exbus_test {
namespace {

using namespace std::chrono_literals;
using reference::plain_exbus;
using reference::plain_exbus_channels;
using Words = std::vector<std::uint16_t>;

// The three examples of Jeti's text, EX Bus protocol 1.21: 16 channels of 8066, a request for
// telemetry, an answer.
constexpr std::string_view kSixteen =
    "3E0328063120821F821F821F821F821F821F821F821F821F821F821F821F821F821F821F821F4FE2";
constexpr std::string_view kAsked = "3D0108063A009881";
constexpr std::string_view kAnswered =
    "3B0120083A189F5600A45155EE11302021004034A328004100005118000991D6";

/// The pulses of the first channels, in us; 0 for one that is absent.
std::vector<double> microseconds(const ChannelFrame& frame, std::size_t count) {
    std::vector<double> values;
    for (std::size_t channel = 0; channel < count; ++channel) {
        values.push_back(frame.channel_or(channel, Pulse{}).microseconds());
    }
    return values;
}

std::size_t frames_in(const Bytes& bytes, Split split = kOneRead) {
    ExBusDecoder decoder;
    return all_frames(decoder, bytes, split).size();
}

/// A line as a receiver makes it: channels, then a request and an answer to it. Packet numbers and
/// values are full of first bytes of frames.
FrameStream line_of(std::uint32_t seed, std::size_t count) {
    constexpr std::array<std::uint8_t, 5> kTraps{0x3E, 0x3D, 0x3B, 0x01, 0x03};
    Random random(seed);
    FrameStream stream;
    for (std::size_t i = 0; i < count; ++i) {
        Bytes data(2 * (1 + random.below(24)));
        std::ranges::generate(data, [&] {
            return random.below(2) == 0 ? kTraps[random.below(kTraps.size())] : random.byte();
        });
        stream.add_frame(plain_exbus(0x3E, random.below(2) == 0 ? 0x01 : 0x03, 0x31, data));
        if (random.below(2) == 0) {
            stream.add_other(from_hex(kAsked));
            stream.add_other(from_hex(kAnswered));
        }
    }
    return stream;
}

TEST(ExBusCrc, HasTheCheckValueOfTheCatalogue) {
    // CRC-16/KERMIT of "123456789"; the one with start FFFF is CRC-16/MCRF4XX.
    const Bytes check{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
    EXPECT_EQ(ExBusCrc::of(0, check), 0x2189);
    EXPECT_EQ(ExBusCrc::of(0xFFFF, check), 0x6F91);
}

TEST(ExBusCrc, EqualsThePlainFormAtEveryLength) {
    Random random(1);
    for (std::size_t length = 0; length <= 64; ++length) {
        Bytes bytes(length);
        std::ranges::generate(bytes, [&] { return random.byte(); });
        EXPECT_EQ(ExBusCrc::of(0, bytes), reference::plain_exbus_check(bytes)) << length;
    }
}

TEST(ExBusDecoder, ReadsTheChannelsOfJetisExample) {
    ExBusDecoder decoder;
    const auto frames = feed(decoder, from_hex(kSixteen), kOneRead, Instant(5ms));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].length, 40U);
    EXPECT_TRUE(frames[0].channels.good());
    EXPECT_EQ(frames[0].channels.received, Instant(5ms));
    EXPECT_EQ(microseconds(frames[0].channels, 16), std::vector<double>(16, 1008.25));
    EXPECT_FALSE(frames[0].channels.has(16));
}

TEST(ExBusDecoder, PassesOverRequestsAndAnswersWithoutARejection) {
    Bytes bytes = from_hex(kSixteen);
    append(bytes, from_hex(kAsked));
    append(bytes, from_hex(kAnswered));
    // A question of the JetiBox, and its answer of two lines of 16 characters.
    append(bytes, plain_exbus(0x3D, 0x01, 0x3B, {0xF0}));
    append(bytes, plain_exbus(0x3B, 0x01, 0x3B, Bytes(32, ' ')));
    append(bytes, plain_exbus(0x3E, 0x01, 0x32, {1, 2, 3}));
    append(bytes, from_hex(kSixteen));
    ExBusDecoder decoder;
    const auto frames = all_frames(decoder, bytes, kByteByByte);
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_EQ(frames[1].first_byte, bytes.size() - 40);
    EXPECT_EQ(decoder.skipped_bytes(), 0U);
    EXPECT_EQ(count_of(decoder, "checksum"), 0U);
}

TEST(ExBusDecoder, ReadsEveryWordOfEveryChannelExactly) {
    for (unsigned word = 0; word <= 0xFFFF; ++word) {
        Words words(18);
        for (std::size_t channel = 0; channel < words.size(); ++channel) {
            words[channel] = static_cast<std::uint16_t>(word + 3641 * channel);
        }
        ExBusDecoder decoder;
        const auto frames = feed(decoder, plain_exbus_channels(words));
        ASSERT_EQ(frames.size(), 1U) << word;
        for (std::size_t channel = 0; channel < words.size(); ++channel) {
            const unsigned sent = words[channel];
            const auto pulse = frames[0].channels.channel(channel);
            ASSERT_EQ(pulse.has_value(), sent >= 1 && sent <= 0x7FFF) << sent;
            ASSERT_TRUE(!pulse || pulse->eighths() == static_cast<int>(sent)) << sent;
        }
    }
}

TEST(ExBusDecoder, ReadsEveryNumberOfChannelsAndKeepsTheFirstEighteen) {
    for (std::size_t count = 1; count <= 24; ++count) {
        Words words(count);
        std::iota(words.begin(), words.end(), std::uint16_t{12000});
        for (const Split split : {kOneRead, kByteByByte}) {
            ExBusDecoder decoder;
            const auto frames = feed(decoder, plain_exbus_channels(words), split);
            ASSERT_EQ(frames.size(), 1U) << count;
            EXPECT_EQ(frames[0].length, 8 + 2 * count);
            const std::size_t kept = std::min<std::size_t>(count, 18);
            EXPECT_EQ(frames[0].channels.absent(), kAllChannels & ~first_channels(kept));
            EXPECT_EQ(frames[0].channels.channel(kept - 1)->eighths(),
                      static_cast<int>(12000 + kept - 1));
        }
    }
}

TEST(ExBusDecoder, RefusesLengthsThatDoNotFit) {
    EXPECT_EQ(frames_in(plain_exbus(0x3E, 0x03, 0x31, {})), 0U) << "no channel";
    EXPECT_EQ(frames_in(plain_exbus(0x3E, 0x03, 0x31, Bytes(49))), 0U) << "half a channel";
    EXPECT_EQ(frames_in(plain_exbus(0x3E, 0x03, 0x31, Bytes(50))), 0U) << "25 channels";
    // The data says 16 channels; the frame is as long as it says, with a right check.
    for (std::size_t length = 8; length <= 0xFF; ++length) {
        Bytes frame = plain_exbus_channels(Words(16, 0x1F1F));
        frame[2] = static_cast<std::uint8_t>(length);
        frame.resize(length - 2, 0x1F);
        const unsigned check = reference::plain_exbus_check(frame);
        frame.push_back(static_cast<std::uint8_t>(check));
        frame.push_back(static_cast<std::uint8_t>(check >> 8U));
        EXPECT_EQ(frames_in(frame), length == 40 ? 1U : 0U) << length;
    }
    for (std::size_t length = 0; length < 8; ++length) {
        Bytes frame = from_hex(kSixteen);
        frame[2] = static_cast<std::uint8_t>(length);
        EXPECT_EQ(frames_in(frame), 0U) << length;
    }
}

TEST(ExBusDecoder, ALongestFrameOfAnotherKindIsPassedOverAndNoLongerOne) {
    for (const std::size_t data : {56U, 57U}) {
        Bytes bytes = plain_exbus(0x3E, 0x01, 0x40, Bytes(data));
        append(bytes, from_hex(kSixteen));
        ExBusDecoder decoder;
        EXPECT_EQ(all_frames(decoder, bytes).size(), 1U);
        EXPECT_EQ(decoder.skipped_bytes(), data == 56 ? 0U : 65U);
    }
}

TEST(ExBusDecoder, RefusesOtherFirstBytesAccessesAndKinds) {
    for (unsigned byte = 0; byte <= 0xFF; ++byte) {
        const auto value = static_cast<std::uint8_t>(byte);
        const Bytes data{0xE0, 0x2E};
        EXPECT_EQ(frames_in(plain_exbus(value, 0x03, 0x31, data)), byte == 0x3E ? 1U : 0U);
        EXPECT_EQ(frames_in(plain_exbus(0x3E, value, 0x31, data)),
                  byte == 0x01 || byte == 0x03 ? 1U : 0U);
        EXPECT_EQ(frames_in(plain_exbus(0x3E, 0x03, value, data)), byte == 0x31 ? 1U : 0U);
    }
}

TEST(ExBusDecoder, RefusesEachFlippedBitAndReadsTheNextFrame) {
    expect_each_flipped_bit_is_refused(make<ExBusDecoder>, from_hex(kSixteen), from_hex(kSixteen));
}

TEST(ExBusDecoder, AFaultAnywhereCostsOnlyTheFrameThatItHits) {
    const FrameStream stream = line_of(1, 6);
    ExBusDecoder undisturbed;
    const auto clean = all_frames(undisturbed, stream.bytes);
    ASSERT_EQ(clean.size(), 6U);
    for (const FaultKind kind :
         {FaultKind::lost, FaultKind::added, FaultKind::replaced, FaultKind::damaged}) {
        for (std::size_t at = 0; at < stream.bytes.size(); ++at) {
            for (const std::uint8_t value : Bytes{0x3E, 0x00, 0xA5}) {
                // A copy of the byte before it could as well have been added one place earlier.
                const bool copy = at > 0 && stream.bytes[at - 1] == value;
                const Fault fault{kind, at - (kind == FaultKind::added && copy ? 1 : 0), value};
                ExBusDecoder decoder;
                const auto frames =
                    all_frames(decoder, stream.bytes, {.longest = 50, .seed = 7}, fault);
                const Damage damage = compare(stream, fault, clean, frames);
                EXPECT_EQ(damage.invented, 0U) << fault;
                EXPECT_LE(damage.missing.size(), 1U) << fault;
            }
        }
    }
}

TEST(ExBusDecoder, FindsAFrameInsideOfAFalseOne) {
    // An answer whose data is a frame of channels: only with a wrong check is that a frame.
    Bytes outer = plain_exbus(0x3B, 0x01, 0x3A, from_hex(kSixteen));
    EXPECT_EQ(frames_in(outer), 0U);
    outer.back() ^= 1U;
    ExBusDecoder decoder;
    const auto frames = all_frames(decoder, outer);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].first_byte, 6U);
    EXPECT_EQ(count_of(decoder, "checksum"), 1U);
}

TEST(ExBusDecoder, FindsAFrameBehindEveryCutOne) {
    expect_a_frame_behind_every_cut_one(make<ExBusDecoder>, from_hex(kSixteen),
                                        plain_exbus_channels(Words(12, 12000)));
}

TEST(ExBusDecoder, APauseEndsAFrame) {
    expect_a_pause_ends_a_frame(make<ExBusDecoder>, from_hex(kSixteen), from_hex(kSixteen));
}

TEST(ExBusDecoder, FindsTheSameFramesHoweverReadsCutTheStream) {
    expect_the_same_however_cut(make<ExBusDecoder>, line_of(2, 100).bytes, 100);
}

TEST(ExBusDecoder, FindsWhatThePlainFormFindsOnAnyLine) {
    for (std::uint32_t seed = 1; seed <= 400; ++seed) {
        Random random(seed);
        Bytes bytes = line_of(seed, 8).bytes;
        for (std::uint32_t fault = random.below(6); fault > 0; --fault) {
            const std::size_t at = random.below(static_cast<std::uint32_t>(bytes.size() - 1));
            constexpr std::array kKinds{FaultKind::lost, FaultKind::added, FaultKind::replaced};
            bytes = with_fault(std::move(bytes), {kKinds[random.below(3)], at, random.byte()});
        }
        ExBusDecoder decoder;
        const auto found = all_frames(decoder, bytes, {.longest = 60, .seed = seed});
        std::size_t count = 0;
        for (const auto& plain : reference::plain_exbus_frames(bytes)) {
            if (!plain.has_channels) {
                continue;
            }
            ASSERT_LT(count, found.size()) << seed;
            EXPECT_EQ(found[count].first_byte, plain.at) << seed;
            EXPECT_EQ(found[count].length, plain.length) << seed;
            EXPECT_EQ(microseconds(found[count].channels, plain.channels.size()), plain.channels)
                << seed;
            ++count;
        }
        EXPECT_EQ(found.size(), count) << seed;
    }
}

TEST(ExBusDecoder, NoFrameHasADamagedByte) {
    for (std::uint32_t seed = 1; seed <= 40; ++seed) {
        ExBusDecoder decoder;
        Random random(seed);
        expect_no_frame_over_damage(decoder, line_of(seed, 10).bytes, random, 90);
    }
}

TEST(ExBus, IsInTheRegistryAsAnInputOnly) {
    EXPECT_EQ(find_protocol("exbus"), &kExBusProtocol);
    EXPECT_TRUE(kExBusProtocol.goes(SettingScope::input));
    EXPECT_FALSE(kExBusProtocol.goes(SettingScope::output));
}

TEST(ExBus, IsHeardByDoctor) {
    Bytes bytes = from_hex(kSixteen);
    append(bytes, from_hex(kAsked));
    const doctor::LineStory story = story_of(kExBusProtocol, {bytes}, 10ms);
    EXPECT_EQ(story.protocol, "exbus");
    EXPECT_EQ(story.channels, 16U);
    EXPECT_EQ(story.period, std::optional<Duration>(10ms));
}

}  // namespace
}  // namespace tribus::test::exbus_test
