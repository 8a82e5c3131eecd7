#include "transports/links/serial/parity_marks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tribus::parity_marks_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A byte as it came off the wire, before the kernel marked it.
struct WireByte {
    std::uint8_t value = 0;
    bool damaged = false;
    bool operator==(const WireByte&) const = default;
};

/// Returns every byte value, undamaged and damaged.
WireByte symbol(unsigned index) {
    return {.value = static_cast<std::uint8_t>(index & 0xFFU), .damaged = index >= 256};
}
constexpr unsigned kSymbols = 512;

/// Adds the byte as the kernel marks it with INPCK and PARMRK: termios(3), PARMRK.
void mark(const WireByte& byte, Bytes& raw) {
    if (byte.damaged) {
        raw.insert(raw.end(), {0xFF, 0x00, byte.value});
    } else if (byte.value == 0xFF) {
        raw.insert(raw.end(), {0xFF, 0xFF});
    } else {
        raw.push_back(byte.value);
    }
}

/// One read of these bytes.
Reception read(ParityMarks& marks, std::span<const std::uint8_t> raw) {
    Reception reception;
    std::ranges::copy(raw, reception.bytes.begin());
    marks.remove(raw.size(), reception);
    return reception;
}

void append(const Reception& reception, std::vector<WireByte>& bytes) {
    for (std::size_t i = 0; i < reception.count; ++i) {
        bytes.push_back({.value = reception.bytes[i], .damaged = reception.damaged.test(i)});
    }
}

std::vector<WireByte> unmark(std::span<const std::uint8_t> raw, std::size_t split) {
    ParityMarks marks;
    std::vector<WireByte> bytes;
    append(read(marks, raw.first(split)), bytes);
    append(read(marks, raw.subspan(split)), bytes);
    return bytes;
}

TEST(ParityMarksTest, EveryPairOfBytesComesThroughWhereverItIsCut) {
    Bytes raw;
    for (unsigned first = 0; first < kSymbols; ++first) {
        for (unsigned second = 0; second < kSymbols; ++second) {
            const std::vector<WireByte> sent{symbol(first), symbol(second)};
            raw.clear();
            mark(sent[0], raw);
            mark(sent[1], raw);
            for (std::size_t split = 0; split <= raw.size(); ++split) {
                ASSERT_EQ(unmark(raw, split), sent)
                    << "bytes " << first << " and " << second << ", cut at " << split;
            }
        }
    }
}

TEST(ParityMarksTest, AllByteValuesComeThroughByteByByte) {
    ParityMarks marks;
    for (unsigned index = 0; index < kSymbols; ++index) {
        Bytes raw;
        mark(symbol(index), raw);
        std::vector<WireByte> bytes;
        for (const std::uint8_t byte : raw) {
            append(read(marks, {&byte, 1}), bytes);
        }
        ASSERT_EQ(bytes, std::vector{symbol(index)});
    }
}

TEST(ParityMarksTest, ABreakIsADamagedZero) {
    // ff 00 00: from a 16550 with PARMRK after a break (docs/protocols/sbus.md, "Serial port:
    // parity").
    const Bytes raw{0xFF, 0x00, 0x00};
    EXPECT_EQ(unmark(raw, 0), (std::vector<WireByte>{{.value = 0, .damaged = true}}));
}

TEST(ParityMarksTest, ADoubledMarkIsOneByte) {
    // 0f ff ff 01: from a 16550 for 0f ff 01 (docs/protocols/sbus.md, "Serial port: parity").
    const Bytes raw{0x0F, 0xFF, 0xFF, 0x01};
    EXPECT_EQ(unmark(raw, 0), (std::vector<WireByte>{{0x0F, false}, {0xFF, false}, {0x01, false}}));
}

TEST(ParityMarksTest, AMarkBeforeAnythingElseIsNotTrusted) {
    const Bytes raw{0xFF, 0x20, 0x40};
    EXPECT_EQ(unmark(raw, 0), (std::vector<WireByte>{{0x20, true}, {0x40, false}}));
}

TEST(ParityMarksTest, AnUnfinishedMarkIsNoByteYet) {
    EXPECT_TRUE(unmark(Bytes{0xFF}, 1).empty());
    EXPECT_TRUE(unmark(Bytes{0xFF, 0x00}, 1).empty());
}

TEST(ParityMarksTest, OneReadOfWhateverBytesFitsOneReception) {
    for (const std::uint8_t filler : Bytes{0x00, 0x20, 0xFF}) {
        ParityMarks marks;
        read(marks, Bytes{0xFF});
        const Reception reception = read(marks, Bytes(kBytesPerRead, filler));
        EXPECT_LE(reception.count, kBytesPerRead);
    }
}

}  // namespace
}  // namespace tribus::parity_marks_test
