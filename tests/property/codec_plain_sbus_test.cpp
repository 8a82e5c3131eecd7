#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "tests/reference/plain_sbus.h"
#include "tests/reference/side_by_side.h"
#include "tests/support/sbus_streams.h"
#include "tests/support/streams.h"
#include "transports/codecs/sbus/sbus.h"

namespace tribus::reference::codec_plain_sbus_test {
namespace {

using test::Bytes;
using test::Random;

using Both = SideBySide<SbusDecoder, PlainSbusDecoder>;

SbusScale betaflight() {
    return *SbusScale::named("betaflight");
}

constexpr std::array<std::uint8_t, 8> kFooters{0x00, 0x00, 0x00, 0x04, 0x14, 0x24, 0x34, 0x08};
/// Bytes with a meaning for the decoder, some of them several times so that they occur often.
constexpr std::array<std::uint8_t, 10> kTelling{0x0F, 0x0F, 0x00, 0x04, 0x08,
                                                0x03, 0x0B, 0x1B, 0x0F, 0xFF};

Bytes random_burst(Random& random, bool hard, const test::SbusPayload& still) {
    const std::uint8_t footer = kFooters[random.below(kFooters.size())];
    Bytes bytes;
    for (std::uint32_t frames = random.below(4); frames > 0; --frames) {
        const auto payload = random.below(2) == 0 ? still : test::random_payload(random, hard);
        test::append(bytes, test::sbus_frame(payload, random.byte() & 0x0FU, footer));
        for (std::uint32_t slot = footer == 0 ? 0 : random.below(10); slot > 0; --slot) {
            test::append(bytes, test::slot_triple(random.below(32), kTelling[random.below(10)],
                                                  kTelling[random.below(10)]));
        }
    }
    for (std::uint32_t count = random.below(hard ? 40 : 8); count > 0; --count) {
        bytes.push_back(hard ? kTelling[random.below(kTelling.size())] : random.byte());
    }
    return bytes;
}

/// Returns frames, SBUS2 frames, slots and noise, with bytes lost, added, changed and damaged.
std::vector<LineByte> random_line(Random& random, std::size_t length) {
    const auto still = test::random_payload(random, true);
    Bytes bytes;
    while (bytes.size() < length) {
        test::append(bytes, random_burst(random, random.below(2) == 0, still));
    }
    return with_random_faults(bytes, kTelling, random);
}

Both both_of(std::uint32_t /*seed*/) {
    return Both(betaflight());
}

TEST(SbusBesidePlain, AnyLineCutAnywhereGivesTheSame) {
    expect_the_same_on_any_line_cut_anywhere(both_of, random_line);
}

TEST(SbusBesidePlain, PausesAnywhereGiveTheSame) {
    expect_the_same_with_pauses_anywhere(both_of, random_line);
}

TEST(SbusBesidePlain, AnyBytesThatTellSomethingGiveTheSame) {
    expect_the_same_on_telling_bytes(both_of, kTelling);
}

RC_GTEST_PROP(SbusBesidePlainProperty, ALineOfAnyBytesGivesTheSame, ()) {
    const auto bytes = *rc::gen::container<Bytes>(rc::gen::weightedOneOf<std::uint8_t>(
        {{3, rc::gen::elementOf(std::vector<std::uint8_t>(kTelling.begin(), kTelling.end()))},
         {1, rc::gen::arbitrary<std::uint8_t>()}}));
    const auto lengths =
        *rc::gen::container<std::vector<std::size_t>>(rc::gen::inRange<std::size_t>(0, 40));
    Both both(betaflight());
    std::span<const std::uint8_t> rest = bytes;
    for (const std::size_t length : lengths) {
        both.read(rest.first(std::min(length, rest.size())));
        rest = rest.subspan(std::min(length, rest.size()));
    }
    both.read(rest);
    both.finish();
    RC_ASSERT(both.difference().empty());
}

/// Returns a stream in which the decoder locks, reads slots, meets a fault and locks again.
std::vector<LineByte> stream_with_a_fault(std::uint8_t footer, bool damaged) {
    Random random(footer + 1U);
    Bytes bytes;
    for (int frame = 0; frame < 5; ++frame) {
        test::append(bytes, test::sbus_frame(test::random_payload(random, true), 0, footer));
        for (std::uint32_t slot = 0; footer != 0 && slot < 2; ++slot) {
            test::append(bytes, test::slot_triple(slot, 0xC0, 0x2E));
        }
        if (frame == 2 && !damaged) {
            bytes.pop_back();
        }
    }
    auto line = on_a_line(bytes);
    line[70].damaged = damaged;
    return line;
}

TEST(SbusBesidePlain, EverySplitInTwoAndInThreeGivesTheSame) {
    for (const std::uint8_t footer : {std::uint8_t{0x00}, std::uint8_t{0x04}}) {
        for (const bool damaged : {false, true}) {
            const auto line = stream_with_a_fault(footer, damaged);
            for (std::size_t first = 0; first < line.size(); ++first) {
                for (std::size_t second = first; second < line.size(); ++second) {
                    Both both(betaflight());
                    const std::array cuts{first, second};
                    both.read(line, cuts);
                    ASSERT_EQ(both.difference(), "") << first << ", " << second;
                }
            }
        }
    }
}

TEST(SbusBesidePlain, EveryRawValueOfEveryChannelIsReadAndWrittenTheSame) {
    for (unsigned channel = 0; channel < kSbusChannels; ++channel) {
        for (unsigned raw = 0; raw <= kSbusRawMost; ++raw) {
            SbusFrame frame;
            for (unsigned other = 0; other < kSbusChannels; ++other) {
                frame.raw[other] = static_cast<std::uint16_t>((raw * 7 + other * 613) % 2048);
            }
            frame.raw[channel] = static_cast<std::uint16_t>(raw);
            frame.channel_17 = (raw & 1U) != 0;
            frame.frame_lost = (raw & 2U) != 0;
            frame.channel_18 = (raw & 4U) != 0;
            frame.failsafe = (raw & 8U) != 0;
            frame.footer = static_cast<std::uint8_t>(raw);
            std::array<std::uint8_t, kSbusFrameLength> wire{};
            std::array<std::uint8_t, kSbusFrameLength> plain_wire{};
            emit_sbus(frame, wire);
            plain_emit_sbus(frame, plain_wire);
            ASSERT_EQ(wire, plain_wire);
            ASSERT_EQ(parse_sbus(wire), frame);
            ASSERT_EQ(plain_parse_sbus(wire), frame);
        }
    }
}

TEST(SbusBesidePlain, EveryRawValueOfEveryChannelComesToTheSamePulseInEveryScale) {
    for (const std::string_view name : {"betaflight", "ardupilot", "px4", "frsky", "futaba"}) {
        Both both(*SbusScale::named(name));
        for (unsigned raw = 0; raw <= kSbusRawMost; ++raw) {
            SbusFrame frame;
            for (unsigned channel = 0; channel < kSbusChannels; ++channel) {
                frame.raw[channel] = static_cast<std::uint16_t>((raw + 683 * channel) % 2048);
            }
            std::array<std::uint8_t, kSbusFrameLength> wire{};
            plain_emit_sbus(frame, wire);
            both.read(wire);
        }
        ASSERT_EQ(both.difference(), "") << name;
        ASSERT_EQ(both.frames(), 2048U) << name;
    }
}

TEST(SbusBesidePlain, EveryPulseOfEveryChannelIsWrittenTheSameInEveryScale) {
    for (const std::string_view name : {"betaflight", "ardupilot", "px4", "frsky", "futaba"}) {
        SbusEncoder encoder(*SbusScale::named(name));
        const PlainSbusEncoder plain(*SbusScale::named(name));
        for (std::int32_t eighths = -32768; eighths <= 32767; ++eighths) {
            ChannelFrame frame;
            for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
                const bool here = (eighths + static_cast<int>(channel)) % 50 != 0;
                if (here || eighths % 2 == 0) {
                    frame.set(channel, Pulse::from_eighths(eighths));
                }
            }
            frame.frame_lost = (eighths & 1) != 0;
            frame.failsafe = (eighths & 2) != 0;
            std::array<std::uint8_t, kLongestSerialFrame> wire{};
            std::array<std::uint8_t, kLongestSerialFrame> plain_wire{};
            ASSERT_EQ(encoder.write(frame, wire, Instant{}), plain.encode(frame, plain_wire));
            ASSERT_EQ(wire, plain_wire) << name << ", " << eighths;
        }
    }
}

RC_GTEST_PROP(SbusScaleProperty, AnyScaleReadsAndWritesAFrameAsItDoesEachValue, ()) {
    const double slope = *rc::gen::oneOf(
        rc::gen::map(rc::gen::inRange(-40, 41), [](int steps) { return steps / 8.0; }),
        rc::gen::map(rc::gen::inRange(25, 400), [](int hundredths) { return hundredths / 100.0; }));
    RC_PRE(std::abs(slope) >= 0.25);
    const double offset = *rc::gen::inRange(-30000, 30000) / 8.0;
    const SbusScale scale = SbusScale::through({{0, 1000}, {offset, offset + 1000 * slope}});
    for (unsigned base = 0; base <= kSbusRawMost; base += kSbusChannels) {
        SbusRaw raw{};
        ChannelFrame sent;
        for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
            raw[channel] = static_cast<std::uint16_t>(base + channel);
            sent.set(channel, Pulse::from_eighths(static_cast<int>(base * 32 + channel) - 32768));
        }
        ChannelFrame each;
        scale.decode_each(raw, each);
        ChannelFrame whole = each;
        SbusRaw encoded = scale.encode_each(sent);
        if (scale.whole_steps()) {
            scale.decode_whole(std::bit_cast<SbusLanes>(raw), whole);
            RC_ASSERT(scale.encode_whole(sent) == encoded);
        }
        for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
            RC_ASSERT(each.channel(channel) == scale.decode(raw[channel]));
            RC_ASSERT(whole.channel(channel) == each.channel(channel));
            RC_ASSERT(encoded[channel] == scale.encode(*sent.channel(channel)));
        }
    }
}

/// Some of these steps have a reciprocal that is too coarse for 16 bits; they must not go that way.
TEST(SbusScaleProperty, EveryPulseIsWrittenTheSameInEveryScaleOfWholeSteps) {
    std::size_t taken = 0;
    for (int step = 2; step <= 31; ++step) {
        for (const double offset : {-3000.0, -1000.5, 0.0, 874.5}) {
            const SbusScale scale =
                SbusScale::through({{0, 1000}, {offset, offset + 1000 * step / 8.0}});
            taken += scale.whole_steps() ? 1U : 0U;
            constexpr int kTogether = kSbusChannels;
            for (int first = -32768; scale.whole_steps() && first < 32768; first += kTogether) {
                ChannelFrame sent;
                for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
                    sent.set(channel, Pulse::from_eighths(first + static_cast<int>(channel)));
                }
                ASSERT_EQ(scale.encode_whole(sent), scale.encode_each(sent))
                    << "step " << step << ", offset " << offset << ", from " << first;
            }
        }
    }
    EXPECT_GT(taken, 20U);
    EXPECT_LT(taken, 110U);
}

}  // namespace
}  // namespace tribus::reference::codec_plain_sbus_test
