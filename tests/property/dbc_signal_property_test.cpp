#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/signal.h"

/// Every signal that fits into the longest frame: each start, each length, both byte orders.
namespace tribus::dbc_signal_property_test {
namespace {

using test::Bytes;
using test::Random;

constexpr unsigned kFrameBits = 512;

std::uint64_t random_bits(Random& random, unsigned length) {
    const std::uint64_t bits = (std::uint64_t{random()} << 32U) | random();
    return bits >> (64 - length);
}

/// Returns the bits of a signal in the frame, least significant first, as docs/protocols/can.md,
/// "DBC files", defines them. Intel goes up from the start bit. Motorola has its most significant
/// bit first: it goes down from the start bit to bit 0 of the byte, then on from bit 7 of the next
/// byte.
std::vector<unsigned> walk(const DbcSignal& signal) {
    std::vector<unsigned> bits;
    unsigned bit = signal.start_bit;
    for (unsigned count = 0; count < signal.bit_length; ++count) {
        if (signal.byte_order == DbcByteOrder::intel) {
            bits.push_back(bit);
            ++bit;
        } else {
            bits.insert(bits.begin(), bit);
            bit = bit % 8 == 0 ? bit + 15 : bit - 1;
        }
    }
    return bits;
}

bool fits(const std::vector<unsigned>& bits) {
    return bits.front() < kFrameBits && bits.back() < kFrameBits;
}

template <class Check>
void for_every_signal(Check check) {
    for (const DbcByteOrder order : {DbcByteOrder::intel, DbcByteOrder::motorola}) {
        for (unsigned start = 0; start < kFrameBits; ++start) {
            for (unsigned length = 1; length <= kLongestDbcSignal; ++length) {
                DbcSignal signal;
                signal.start_bit = start;
                signal.bit_length = length;
                signal.byte_order = order;
                const std::vector<unsigned> bits = walk(signal);
                if (fits(bits)) {
                    SCOPED_TRACE(std::to_string(start) + "|" + std::to_string(length) +
                                 (order == DbcByteOrder::intel ? "@1" : "@0"));
                    check(signal, bits);
                    if (testing::Test::HasFailure()) {
                        return;
                    }
                }
            }
        }
    }
}

Bytes random_frame(Random& random) {
    Bytes frame(kFrameBits / 8);
    for (std::uint8_t& byte : frame) {
        byte = random.byte();
    }
    return frame;
}

bool bit_of(const Bytes& frame, unsigned bit) {
    return ((unsigned{frame[bit / 8]} >> (bit % 8)) & 1U) != 0;
}

TEST(DbcLayoutProperty, ReadsTheBitsThatTheWalkVisits) {
    Random random(1);
    for_every_signal([&](const DbcSignal& signal, const std::vector<unsigned>& bits) {
        const Bytes frame = random_frame(random);
        std::uint64_t expected = 0;
        for (std::size_t at = 0; at < bits.size(); ++at) {
            expected |= std::uint64_t{bit_of(frame, bits[at])} << at;
        }
        EXPECT_EQ(DbcLayout(signal).raw_bits(frame), expected);
    });
}

TEST(DbcLayoutProperty, ReadsBackWhatItWroteAndLeavesItsNeighboursAlone) {
    Random random(2);
    for_every_signal([&](const DbcSignal& signal, const std::vector<unsigned>& bits) {
        const DbcLayout layout(signal);
        const Bytes before = random_frame(random);
        const std::uint64_t written = random_bits(random, signal.bit_length);
        Bytes after = before;
        layout.set_raw_bits(after, written);
        EXPECT_EQ(layout.raw_bits(after), written);
        Bytes restored = after;
        for (const unsigned bit : bits) {
            const auto mask = static_cast<std::uint8_t>(1U << (bit % 8));
            restored[bit / 8] =
                static_cast<std::uint8_t>((restored[bit / 8] & ~mask) | (before[bit / 8] & mask));
        }
        EXPECT_EQ(restored, before);
    });
}

TEST(DbcLayoutProperty, NeedsTheBytesUpToItsLastOne) {
    for_every_signal([&](const DbcSignal& signal, const std::vector<unsigned>& bits) {
        const std::size_t needed = std::max(bits.front(), bits.back()) / 8 + 1;
        const DbcLayout layout(signal);
        EXPECT_EQ(layout.needed_bytes(), needed);
        Bytes shortest(needed, 0xFF);
        EXPECT_EQ(layout.raw_bits(shortest), ~std::uint64_t{0} >> (64 - signal.bit_length));
    });
}

TEST(DbcLayoutProperty, PhysicalValuesGoBackToTheirBits) {
    Random random(3);
    for (unsigned round = 0; round < 200'000; ++round) {
        DbcSignal signal;
        constexpr double kFactors[]{1, -1, 0.5, 0.125, 0.1, 0.01, 1e-3, 0.3048, 1e6};
        constexpr double kOffsets[]{0, 476, -40, -0.5, 1e3};
        signal.bit_length = 1 + random.below(48);
        signal.is_signed = random.below(2) == 1;
        signal.factor = kFactors[random.below(std::size(kFactors))];
        signal.offset = kOffsets[random.below(std::size(kOffsets))];
        const DbcLayout layout(signal);
        const std::uint64_t bits = random_bits(random, signal.bit_length);
        ASSERT_EQ(layout.bits_from_physical(layout.physical(bits)), bits)
            << signal.bit_length << " bits, factor " << signal.factor << ", offset "
            << signal.offset;
    }
}

TEST(DbcLayoutProperty, NoPhysicalValueIsNearerThanTheOneChosen) {
    Random random(4);
    for (unsigned round = 0; round < 20'000; ++round) {
        DbcSignal signal;
        signal.bit_length = 1 + random.below(12);
        signal.is_signed = random.below(2) == 1;
        signal.factor = (random.below(2) == 1 ? 0.01 : -0.01) * (1 + random.below(1000));
        signal.offset = random.below(2000) - 1000.0;
        const DbcLayout layout(signal);
        const double wanted = (random.below(200'000) - 100'000.0) * 0.5;
        const double chosen = layout.physical(layout.bits_from_physical(wanted));
        for (std::uint64_t bits = 0; bits < (std::uint64_t{1} << signal.bit_length); ++bits) {
            ASSERT_LE(std::abs(chosen - wanted), std::abs(layout.physical(bits) - wanted) + 1e-9);
        }
    }
}

TEST(DbcLayoutProperty, AllFiniteFloatsGoBackToTheirBits) {
    Random random(5);
    DbcSignal single;
    single.bit_length = 32;
    single.kind = DbcValueKind::float32;
    const DbcLayout layout(single);
    constexpr std::uint64_t kMinusZero = 0x80000000U;
    for (unsigned round = 0; round < 100'000; ++round) {
        const std::uint64_t bits = random();
        const double physical = layout.physical(bits);
        if (std::isfinite(physical) && bits != kMinusZero) {
            ASSERT_EQ(layout.bits_from_physical(physical), bits);
        }
    }
}

}  // namespace
}  // namespace tribus::dbc_signal_property_test
