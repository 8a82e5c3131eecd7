#include "transports/codecs/dbc/signal.h"

#include <array>

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::signal_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

DbcSignal field(unsigned start_bit, unsigned bit_length, DbcByteOrder byte_order) {
    DbcSignal signal;
    signal.start_bit = start_bit;
    signal.bit_length = bit_length;
    signal.byte_order = byte_order;
    return signal;
}

DbcSignal number(unsigned bit_length, bool is_signed, double factor = 1, double offset = 0) {
    DbcSignal signal = field(0, bit_length, DbcByteOrder::intel);
    signal.is_signed = is_signed;
    signal.factor = factor;
    signal.offset = offset;
    return signal;
}

DbcSignal floating(DbcValueKind kind, double factor = 1, double offset = 0) {
    DbcSignal signal = number(kind == DbcValueKind::float32 ? 32 : 64, true, factor, offset);
    signal.kind = kind;
    return signal;
}

constexpr std::array<std::uint8_t, 9> kBytes{0x12, 0x34, 0x56, 0x78, 0x9A, 0xBC, 0xDE, 0xF0, 0x13};

TEST(DbcLayout, ReadsIntelFromItsLowestBitUpwards) {
    EXPECT_EQ(DbcLayout(field(0, 8, DbcByteOrder::intel)).raw_bits(kBytes), 0x12U);
    EXPECT_EQ(DbcLayout(field(8, 16, DbcByteOrder::intel)).raw_bits(kBytes), 0x5634U);
    EXPECT_EQ(DbcLayout(field(4, 12, DbcByteOrder::intel)).raw_bits(kBytes), 0x341U);
}

// docs/protocols/can.md, "DBC files": 39|16@0 is a big-endian number in bytes 4 and 5.
TEST(DbcLayout, ReadsMotorolaFromItsHighestBitDownwards) {
    EXPECT_EQ(DbcLayout(field(39, 16, DbcByteOrder::motorola)).raw_bits(kBytes), 0x9ABCU);
    EXPECT_EQ(DbcLayout(field(3, 12, DbcByteOrder::motorola)).raw_bits(kBytes), 0x234U);
    EXPECT_EQ(DbcLayout(field(7, 12, DbcByteOrder::motorola)).raw_bits(kBytes), 0x123U);
}

TEST(DbcLayout, Reads64BitsAcrossNineBytes) {
    // Bytes 13 F0 DE BC 9A 78 56 34 12, highest first, without the lowest and the upper four bits.
    EXPECT_EQ(DbcLayout(field(4, 64, DbcByteOrder::intel)).raw_bits(kBytes), 0x3F0DEBC9A7856341U);
    EXPECT_EQ(DbcLayout(field(3, 64, DbcByteOrder::motorola)).raw_bits(kBytes),
              0x23456789ABCDEF01U);
}

TEST(DbcLayout, WritesItsOwnBitsOnly) {
    std::array<std::uint8_t, 3> data{0xFF, 0xFF, 0xFF};
    DbcLayout(field(4, 12, DbcByteOrder::intel)).set_raw_bits(data, 0x123);
    EXPECT_EQ(data, (std::array<std::uint8_t, 3>{0x3F, 0x12, 0xFF}));
    data = {0, 0, 0};
    DbcLayout(field(11, 12, DbcByteOrder::motorola)).set_raw_bits(data, 0x123);
    EXPECT_EQ(data, (std::array<std::uint8_t, 3>{0, 0x01, 0x23}));
}

TEST(DbcLayout, WritesOnlyAsManyBitsAsItHas) {
    std::array<std::uint8_t, 1> data{0};
    DbcLayout(field(2, 3, DbcByteOrder::intel)).set_raw_bits(data, 0xFFFF);
    EXPECT_EQ(data[0], 0x1C);
}

TEST(DbcLayout, KnowsHowLongAFrameMustBe) {
    EXPECT_EQ(DbcLayout(field(0, 8, DbcByteOrder::intel)).needed_bytes(), 1U);
    EXPECT_EQ(DbcLayout(field(1, 8, DbcByteOrder::intel)).needed_bytes(), 2U);
    EXPECT_EQ(DbcLayout(field(7, 8, DbcByteOrder::motorola)).needed_bytes(), 1U);
    EXPECT_EQ(DbcLayout(field(6, 8, DbcByteOrder::motorola)).needed_bytes(), 2U);
    EXPECT_EQ(DbcLayout(field(511, 1, DbcByteOrder::motorola)).needed_bytes(), 64U);
}

TEST(DbcLayout, ScalesByFactorThenOffset) {
    EXPECT_EQ(DbcLayout(number(12, false, 0.5, 476)).physical(4095), 2523.5);
    EXPECT_EQ(DbcLayout(number(8, false, -2, 10)).physical(255), -500);
}

TEST(DbcLayout, ReadsSignedAsTwosComplement) {
    EXPECT_EQ(DbcLayout(number(12, true, 0.5, 1)).physical(0xFFF), 0.5);
    EXPECT_EQ(DbcLayout(number(1, true)).physical(1), -1);
    EXPECT_EQ(DbcLayout(number(64, true)).physical(~std::uint64_t{0}), -1);
    EXPECT_EQ(DbcLayout(number(64, false)).physical(~std::uint64_t{0}), 18446744073709551616.0);
}

TEST(DbcLayout, ReadsFloats) {
    // IEEE 754: 1.5 is 0x3FC00000, -0.1 nearest 0xBFB999999999999A.
    EXPECT_EQ(DbcLayout(floating(DbcValueKind::float32)).physical(0x3FC00000), 1.5);
    EXPECT_EQ(DbcLayout(floating(DbcValueKind::float64)).physical(0xBFB999999999999A), -0.1);
    EXPECT_EQ(DbcLayout(floating(DbcValueKind::float32, 2, 1)).physical(0x3FC00000), 4);
    EXPECT_TRUE(std::isnan(DbcLayout(floating(DbcValueKind::float32)).physical(0xFFFFFFFF)));
}

TEST(DbcLayout, RoundsToTheNearestRawValue) {
    const DbcLayout layout(number(12, false, 0.5, 476));
    EXPECT_EQ(layout.bits_from_physical(1500), 2048U);
    EXPECT_EQ(layout.bits_from_physical(1500.24), 2048U);
    EXPECT_EQ(layout.bits_from_physical(1500.25), 2049U);
    EXPECT_EQ(layout.bits_from_physical(1500.26), 2049U);
    EXPECT_EQ(DbcLayout(number(8, true)).bits_from_physical(-2.5), 0xFDU);
}

TEST(DbcLayout, SaturatesUnsigned) {
    const DbcLayout layout(number(12, false, 0.5, 476));
    EXPECT_EQ(layout.bits_from_physical(475), 0U);
    EXPECT_EQ(layout.bits_from_physical(1e9), 4095U);
    EXPECT_EQ(layout.bits_from_physical(kInfinity), 4095U);
    EXPECT_EQ(layout.bits_from_physical(-kInfinity), 0U);
    EXPECT_EQ(DbcLayout(number(64, false)).bits_from_physical(1e300), ~std::uint64_t{0});
    EXPECT_EQ(DbcLayout(number(64, false)).bits_from_physical(-1), 0U);
}

TEST(DbcLayout, SaturatesSigned) {
    EXPECT_EQ(DbcLayout(number(8, true)).bits_from_physical(128), 0x7FU);
    EXPECT_EQ(DbcLayout(number(8, true)).bits_from_physical(-129), 0x80U);
    EXPECT_EQ(DbcLayout(number(1, true)).bits_from_physical(5), 0U);
    EXPECT_EQ(DbcLayout(number(1, true)).bits_from_physical(-5), 1U);
    EXPECT_EQ(DbcLayout(number(64, true)).bits_from_physical(1e19), 0x7FFFFFFFFFFFFFFFU);
    EXPECT_EQ(DbcLayout(number(64, true)).bits_from_physical(-1e19), 0x8000000000000000U);
}

TEST(DbcLayout, SaturatesTheOtherWayByANegativeFactor) {
    const DbcLayout layout(number(8, false, -1, 0));
    EXPECT_EQ(layout.bits_from_physical(-1e9), 255U);
    EXPECT_EQ(layout.bits_from_physical(1e9), 0U);
}

TEST(DbcLayout, SaturatesFloatsToTheGreatestFiniteOne) {
    const DbcLayout single(floating(DbcValueKind::float32));
    EXPECT_EQ(single.bits_from_physical(1e300), 0x7F7FFFFFU);
    EXPECT_EQ(single.bits_from_physical(-kInfinity), 0xFF7FFFFFU);
    const DbcLayout wide(floating(DbcValueKind::float64));
    EXPECT_EQ(wide.bits_from_physical(kInfinity), 0x7FEFFFFFFFFFFFFFU);
}

TEST(DbcLayout, WritesFloats) {
    EXPECT_EQ(DbcLayout(floating(DbcValueKind::float32, 2, 1)).bits_from_physical(4), 0x3FC00000U);
    EXPECT_EQ(DbcLayout(floating(DbcValueKind::float64)).bits_from_physical(-0.1),
              0xBFB999999999999AU);
}

TEST(DbcLayout, WritesNotANumberAsZeroBits) {
    EXPECT_EQ(DbcLayout(number(12, false, 0.5, 476)).bits_from_physical(kNotANumber), 0U);
    EXPECT_EQ(DbcLayout(number(8, true)).bits_from_physical(kNotANumber), 0U);
    EXPECT_EQ(DbcLayout(floating(DbcValueKind::float32)).bits_from_physical(kNotANumber), 0U);
}

TEST(DbcLayout, GivesRawValuesAsNumbers) {
    EXPECT_EQ(DbcLayout(number(12, true)).raw_value(0xFFF), -1);
    EXPECT_EQ(DbcLayout(number(12, false)).raw_value(0xFFF), 4095);
    EXPECT_EQ(DbcLayout(floating(DbcValueKind::float32)).raw_value(0xFFFFFFFF), 0xFFFFFFFF);
}

TEST(DbcLayout, TakesRawValuesThatItCanHold) {
    EXPECT_EQ(DbcLayout(number(12, true)).bits_from_raw(-1), 0xFFFU);
    EXPECT_EQ(DbcLayout(number(12, true)).bits_from_raw(2048), std::nullopt);
    EXPECT_EQ(DbcLayout(number(12, false)).bits_from_raw(4095), 0xFFFU);
    EXPECT_EQ(DbcLayout(number(12, false)).bits_from_raw(4096), std::nullopt);
    EXPECT_EQ(DbcLayout(number(12, false)).bits_from_raw(-1), std::nullopt);
    EXPECT_EQ(DbcLayout(number(64, false)).bits_from_raw(-1), ~std::uint64_t{0});
}

/// Outer (byte 0) selects Inner (byte 1) with 3. Inner selects Deep (byte 2) with 5 or 16 to 20.
DbcMessage nested() {
    DbcMessage message;
    message.length = 8;
    DbcSignal outer = field(0, 8, DbcByteOrder::intel);
    outer.is_selector = true;
    DbcSignal inner = field(8, 8, DbcByteOrder::intel);
    inner.is_selector = true;
    inner.selector = 0;
    inner.selected_by = {{3, 3}};
    DbcSignal deep = field(16, 8, DbcByteOrder::intel);
    deep.selector = 1;
    deep.selected_by = {{5, 5}, {16, 20}};
    message.signals = {outer, inner, deep};
    return message;
}

bool deep_present(const std::vector<std::uint8_t>& data) {
    const DbcMessage message = nested();
    return present(message, message.signals[2], data);
}

TEST(DbcPresent, ForASignalThatDependsOnNothing) {
    const DbcMessage message = nested();
    EXPECT_TRUE(present(message, message.signals[0], std::array<std::uint8_t, 1>{0}));
}

TEST(DbcPresent, NeedsASelectorInOneOfTheRanges) {
    EXPECT_TRUE(deep_present({3, 5, 0}));
    EXPECT_TRUE(deep_present({3, 16, 0}));
    EXPECT_TRUE(deep_present({3, 20, 0}));
    EXPECT_FALSE(deep_present({3, 4, 0}));
    EXPECT_FALSE(deep_present({3, 15, 0}));
    EXPECT_FALSE(deep_present({3, 21, 0}));
}

TEST(DbcPresent, NeedsTheSelectorItselfPresent) {
    EXPECT_FALSE(deep_present({2, 5, 0}));
}

TEST(DbcPresent, NotInAFrameThatIsTooShort) {
    EXPECT_FALSE(deep_present({3, 5}));
    EXPECT_FALSE(deep_present({}));
}

TEST(DbcPresent, NotIfTheFrameIsTooShortForItsSelector) {
    DbcMessage message = nested();
    std::swap(message.signals[0].start_bit, message.signals[2].start_bit);
    EXPECT_FALSE(present(message, message.signals[2], std::array<std::uint8_t, 2>{5, 5}));
}

TEST(DbcPresence, ASignalOfAnUnknownPageIsNeverThereNorIsWhatItSelects) {
    DbcMessage message;
    message.length = 2;
    DbcSignal selector;
    selector.bit_length = 8;
    selector.is_selector = true;
    selector.page_unknown = true;
    DbcSignal selected;
    selected.start_bit = 8;
    selected.bit_length = 8;
    selected.selector = 0;
    selected.selected_by = {{3, 3}};
    message.signals = {selector, selected};
    const std::array<std::uint8_t, 2> data{3, 0};
    EXPECT_FALSE(present(message, message.signals[0], data));
    EXPECT_FALSE(present(message, message.signals[1], data));
    message.signals[0].page_unknown = false;
    EXPECT_TRUE(present(message, message.signals[1], data));
}

}  // namespace
}  // namespace tribus::signal_test
