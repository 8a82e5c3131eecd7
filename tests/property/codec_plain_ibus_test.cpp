#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/reference/plain_ibus.h"
#include "tests/reference/side_by_side.h"
#include "tests/support/ibus_frames.h"
#include "tests/support/streams.h"
#include "transports/codecs/ibus/ibus.h"

namespace tribus::reference::codec_plain_ibus_test {
namespace {

using test::Bytes;
using test::Random;
using test::servo_frame;

using Both = SideBySide<IbusDecoder, PlainIbusDecoder>;

/// Bytes with a meaning for the decoder: lengths, commands, and first bytes of i-BUS2.
constexpr std::array<std::uint8_t, 14> kTelling{0x20, 0x40, 0x55, 0x00, 0x06, 0x40, 0x08,
                                                0x1E, 0x25, 0x04, 0x0A, 0x20, 0x05, 0xDC};

Bytes random_payload(Random& random, std::size_t length) {
    const std::uint32_t kind = random.below(4);
    Bytes payload(length);
    for (std::uint8_t& byte : payload) {
        byte = kind == 0 ? kTelling[random.below(kTelling.size())] : random.byte();
        byte = kind == 1 && random.below(2) == 0 ? 0 : byte;
    }
    return payload;
}

Bytes ia6_frame(Random& random) {
    Bytes frame{0x55};
    unsigned sum = 0;
    for (int slot = 0; slot < 14; ++slot) {
        const unsigned word = random.below(random.below(8) == 0 ? 0x1100 : 0x1000);
        sum += word;
        frame.push_back(static_cast<std::uint8_t>(word));
        frame.push_back(static_cast<std::uint8_t>(word >> 8U));
    }
    frame.push_back(static_cast<std::uint8_t>(sum));
    frame.push_back(static_cast<std::uint8_t>(sum >> 8U));
    return frame;
}

Bytes ibus2_frame(Random& random) {
    Bytes frame{static_cast<std::uint8_t>(random.below(3) << 2U),
                static_cast<std::uint8_t>(8 + random.below(30))};
    test::append(frame, random_payload(random, frame[1] - 3U));
    unsigned crc = 0xFF;
    for (const std::uint8_t byte : frame) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc << 1U) ^ ((crc & 0x80U) != 0 ? 0x125U : 0U);
        }
    }
    frame.push_back(static_cast<std::uint8_t>(crc));
    return frame;
}

Bytes random_piece(Random& random) {
    switch (random.below(8)) {
        case 0:
            return ia6_frame(random);
        case 1:
            return ibus2_frame(random);
        case 2:
            return random_payload(random, random.below(20));
        case 3:
            return servo_frame(random_payload(random, 2 * (1 + random.below(14))), 0x40);
        case 4:
            return servo_frame(random_payload(random, 28), 0x00);
        default:
            return servo_frame(random_payload(random, 28), 0x40);
    }
}

std::vector<LineByte> random_line(Random& random, std::size_t length) {
    Bytes bytes;
    const bool only_ibus2 = random.below(4) == 0;
    while (bytes.size() < length) {
        test::append(bytes, only_ibus2 ? ibus2_frame(random) : random_piece(random));
    }
    return with_random_faults(bytes, kTelling, random);
}

Both both_of(std::uint32_t seed) {
    return Both(seed % 3 == 0 ? IbusSlots::plain : IbusSlots::nibbles);
}

TEST(IbusBesidePlain, AnyLineCutAnywhereGivesTheSame) {
    expect_the_same_on_any_line_cut_anywhere(both_of, random_line);
}

TEST(IbusBesidePlain, PausesAnywhereGiveTheSame) {
    expect_the_same_with_pauses_anywhere(both_of, random_line);
}

TEST(IbusBesidePlain, AnyBytesThatTellSomethingGiveTheSame) {
    expect_the_same_on_telling_bytes(both_of, kTelling);
}

RC_GTEST_PROP(IbusBesidePlainProperty, ALineOfAnyBytesGivesTheSame, ()) {
    const auto bytes = *rc::gen::container<Bytes>(rc::gen::weightedOneOf<std::uint8_t>(
        {{3, rc::gen::elementOf(std::vector<std::uint8_t>(kTelling.begin(), kTelling.end()))},
         {1, rc::gen::arbitrary<std::uint8_t>()}}));
    const auto lengths =
        *rc::gen::container<std::vector<std::size_t>>(rc::gen::inRange<std::size_t>(0, 40));
    Both both(IbusSlots::nibbles);
    std::span<const std::uint8_t> rest = bytes;
    for (const std::size_t length : lengths) {
        both.read(rest.first(std::min(length, rest.size())));
        rest = rest.subspan(std::min(length, rest.size()));
    }
    both.read(rest);
    RC_ASSERT(both.difference().empty());
}

TEST(IbusBesidePlain, EverySplitInTwoAndInThreeGivesTheSame) {
    Random random(1);
    for (const bool damaged : {false, true}) {
        Bytes bytes = servo_frame(random_payload(random, 28), 0x40);
        test::append(bytes, ibus2_frame(random));
        test::append(bytes, servo_frame({0x20, 0x40, 0x20, 0x40, 0x55, 0x05}, 0x40));
        test::append(bytes, Bytes{0x20, 0x40, 0x20});
        test::append(bytes, ia6_frame(random));
        test::append(bytes, servo_frame(random_payload(random, 28), 0x40));
        auto line = on_a_line(bytes);
        line[90].damaged = damaged;
        for (std::size_t first = 0; first < line.size(); ++first) {
            for (std::size_t second = first; second < line.size(); ++second) {
                Both both(IbusSlots::nibbles);
                const std::array cuts{first, second};
                both.read(line, cuts);
                ASSERT_EQ(both.difference(), "") << first << ", " << second;
            }
        }
    }
}

TEST(IbusBesidePlain, EveryWordOfEverySlotIsReadTheSame) {
    for (const IbusSlots slots : {IbusSlots::nibbles, IbusSlots::plain}) {
        Both both(slots);
        for (unsigned word = 0; word <= 0xFFFF; ++word) {
            Bytes payload;
            for (unsigned slot = 0; slot < 14; ++slot) {
                const unsigned here = word + slot * (word % 3 == 0 ? 0U : 4681U);
                payload.push_back(static_cast<std::uint8_t>(here));
                payload.push_back(static_cast<std::uint8_t>(here >> 8U));
            }
            both.read(servo_frame(payload, 0x40));
        }
        EXPECT_EQ(both.difference(), "");
        EXPECT_EQ(both.frames(), 0x10000U);
    }
}

TEST(IbusBesidePlain, EveryValueOfChannels15To18IsReadTheSame) {
    Both both(IbusSlots::nibbles);
    for (unsigned value = 0; value <= 0xFFF; ++value) {
        Bytes payload;
        for (unsigned slot = 0; slot < 14; ++slot) {
            const unsigned here = (value + 911 * (slot / 3)) & 0xFFFU;
            const unsigned nibble = slot < 12 ? here >> (4 * (slot % 3)) & 0xFU : 0;
            payload.push_back(0xDC);
            payload.push_back(static_cast<std::uint8_t>(nibble << 4U | 0x05U));
        }
        both.read(servo_frame(payload, 0x40));
    }
    EXPECT_EQ(both.difference(), "");
    EXPECT_EQ(both.frames(), 0x1000U);
}

TEST(IbusBesidePlain, EveryPulseOfEveryChannelIsWrittenTheSame) {
    for (const std::size_t channels : {14U, 18U}) {
        IbusEncoder encoder(channels);
        const PlainIbusEncoder plain(channels);
        for (std::int32_t eighths = -32768; eighths <= 32767; ++eighths) {
            ChannelFrame frame;
            for (int channel = 0; channel < static_cast<int>(kChannelCount); ++channel) {
                const bool here = (eighths + channel) % 50 != 0;
                if (here || eighths % 2 == 0) {
                    const int value = eighths % 3 == 0 ? eighths : eighths / 4 + 8 * 500 * channel;
                    frame.set(static_cast<std::size_t>(channel), Pulse::from_eighths(value));
                }
            }
            std::array<std::uint8_t, kLongestSerialFrame> wire{};
            std::array<std::uint8_t, kLongestSerialFrame> plain_wire{};
            ASSERT_EQ(encoder.write(frame, wire, Instant{}), plain.encode(frame, plain_wire));
            ASSERT_EQ(wire, plain_wire) << eighths;
        }
    }
}

}  // namespace
}  // namespace tribus::reference::codec_plain_ibus_test
