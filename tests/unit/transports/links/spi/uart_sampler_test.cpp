#include "transports/links/spi/uart_sampler.h"

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/sampled_line.h"
#include "transports/links/spi/uart_waveform.h"

/// Bytes of a serial line, found in samples of an SPI port.
namespace tribus::test::uart_sampler_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr LineSettings kSbusLine{
    .baud = 100000, .parity = Parity::even, .stop_bits = 2, .inverted_wire = true};

SampledBlock found_in(const Bytes& samples, const LineSettings& line = kSbusLine) {
    SampledBlock block;
    sample_uart(samples, line, block);
    return block;
}

/// The values of undamaged bytes, and -1 for each damaged one.
std::vector<int> values(const SampledBlock& block) {
    std::vector<int> all;
    for (const SampledByte& byte : block.view()) {
        all.push_back(byte.damaged ? -1 : byte.value);
    }
    return all;
}

/// Rests for as long as a byte lasts, then these bits of the line, then rest again; a byte of
/// samples a bit.
Bytes line_of(const std::vector<int>& levels) {
    Bytes samples(12, 0x00);
    for (const int level : levels) {
        samples.push_back(level != 0 ? 0xFF : 0x00);
    }
    samples.resize(samples.size() + 12, 0x00);
    return samples;
}

/// 0x0F with even parity and two stop bits, inverted (docs/protocols/sbus.md, "Line").
TEST(UartSampler, FindsAByteOfAnInvertedLine) {
    const SampledBlock block = found_in(line_of({1, 0, 0, 0, 0, 1, 1, 1, 1, 1, 0, 0}));
    EXPECT_EQ(values(block), std::vector{0x0F});
    EXPECT_EQ(block.bytes[0].begin, 12U * 8U);
    EXPECT_FALSE(block.cut);
}

TEST(UartSampler, MarksAParityErrorAndAMissingStopBit) {
    EXPECT_EQ(values(found_in(line_of({1, 0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0}))), std::vector{-1});
    EXPECT_EQ(values(found_in(line_of({1, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 0}))), std::vector{-1});
}

TEST(UartSampler, TakesABreakForOneDamagedByte) {
    EXPECT_EQ(values(found_in(line_of(std::vector<int>(100, 1)))), std::vector{-1});
    EXPECT_TRUE(values(found_in(Bytes(500, 0xFF))).empty());
}

TEST(UartSampler, TakesNoPulseForAStartThatIsShorterThanHalfABit) {
    Bytes samples = line_of({0, 1, 0, 0, 0, 0, 1, 1, 1, 1, 1, 0, 0});
    samples[12] = 0xE0;
    EXPECT_EQ(values(found_in(samples)), std::vector{0x0F});
}

/// All bytes, with and without parity, inverted and not, as `draw_uart` draws them.
TEST(UartSampler, FindsAllBytesOfAllLines) {
    Bytes all(256);
    for (std::size_t i = 0; i < all.size(); ++i) {
        all[i] = static_cast<std::uint8_t>(i);
    }
    for (const Parity parity : {Parity::none, Parity::even}) {
        for (const std::uint8_t stop_bits : {std::uint8_t{1}, std::uint8_t{2}}) {
            for (const bool inverted : {false, true}) {
                const LineSettings line{.baud = 100'000,
                                        .parity = parity,
                                        .stop_bits = stop_bits,
                                        .inverted_wire = inverted};
                SpiWaveform waveform;
                ASSERT_TRUE(draw_uart(all, line, waveform));
                Bytes samples(12, inverted ? 0x00 : 0xFF);
                samples.insert(samples.end(), waveform.bits.begin(),
                               waveform.bits.begin() + static_cast<std::ptrdiff_t>(waveform.bytes));
                const SampledBlock block = found_in(samples, line);
                ASSERT_EQ(block.count, 256U);
                for (std::size_t i = 0; i < all.size(); ++i) {
                    EXPECT_EQ(block.bytes[i].value, all[i]);
                    EXPECT_FALSE(block.bytes[i].damaged);
                }
            }
        }
    }
}

TEST(UartSampler, LeavesOutWhatTheBlockBeginsWithin) {
    SampledLine line;
    line.send(0, Bytes(25, 0x5A));
    line.send(5000, Bytes{0x0F});
    const SampledBlock block = found_in(line.sample(700, 700));
    EXPECT_EQ(values(block), std::vector{0x0F});
}

TEST(UartSampler, SaysWhereTheBlockCutsAByteOrFollowsOneAtOnce) {
    SampledLine line;
    line.send(200, Bytes(2, 0x5A));
    const auto cut = [&](std::size_t bits) { return found_in(line.sample(0, bits)); };
    EXPECT_FALSE(cut(20).cut);
    EXPECT_TRUE(cut(25).cut);
    EXPECT_EQ(cut(31).count, 1U);
    EXPECT_TRUE(cut(31).cut) << "the second may follow";
    EXPECT_EQ(cut(43).count, 2U);
    EXPECT_TRUE(cut(44).cut) << "a third may follow";
    EXPECT_FALSE(cut(56).cut);
}

struct Clocks {
    double a_byte;         ///< of the controller
    double byte_us;        ///< measured within 0.5 %
    double sender_faster;  ///< of the sender's clock
};

class UartSamplerOfAController : public testing::TestWithParam<Clocks> {};

/// 10,000 frames from any phase, each as it was sent.
TEST_P(UartSamplerOfAController, ReadsEachRandomFrameAsItWasSent) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> phase(200, 210);
    for (int i = 0; i < 10'000; ++i) {
        SampledLine line(GetParam().sender_faster);
        Bytes frame(25);
        std::ranges::generate(frame, [&] { return static_cast<std::uint8_t>(random()); });
        line.send(phase(random), frame);
        const SampledBlock block =
            found_in(line.sample(0, 345, GetParam().a_byte, GetParam().byte_us));
        ASSERT_EQ(values(block), std::vector<int>(frame.begin(), frame.end()));
    }
}

INSTANTIATE_TEST_SUITE_P(Controllers, UartSamplerOfAController,
                         testing::Values(Clocks{8, 10, 0}, Clocks{9, 10, 0}, Clocks{8.25, 10, 0},
                                         Clocks{8, 9.95, 0.02}, Clocks{8, 10.05, -0.02},
                                         Clocks{9, 10.05, 0.02}, Clocks{9, 9.95, -0.02}),
                         [](const auto& test) {
                             return "With" +
                                    std::to_string(static_cast<int>(test.param.a_byte * 100)) +
                                    "Clocks" + std::to_string(test.index);
                         });

/// Whatever is on the line, and wherever a block begins and ends.
TEST(UartSampler, FindsNoMoreBytesThanFitInAnySamples) {
    std::mt19937 random(2);
    for (int i = 0; i < 20'000; ++i) {
        Bytes samples(random() % 200);
        const unsigned kind = random() % 4;
        std::ranges::generate(samples, [&] {
            return static_cast<std::uint8_t>(kind == 0   ? random()
                                             : kind == 1 ? (random() % 2 != 0 ? 0xFF : 0)
                                             : kind == 2 ? (random() % 20 == 0 ? 0xFF : 0)
                                                         : (random() % 20 == 0 ? random() : 0));
        });
        const SampledBlock block = found_in(samples);
        // Start bit, data and parity.
        ASSERT_LE(block.count * 10, samples.size());
        for (std::size_t byte = 1; byte < block.count; ++byte) {
            ASSERT_GE(block.bytes[byte].begin, block.bytes[byte - 1].begin + 10 * 8);
        }
    }
}

}  // namespace
}  // namespace tribus::test::uart_sampler_test
