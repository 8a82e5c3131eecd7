#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pipelines/engine/input.h"
#include "tests/unit/pipelines/engine/engine_bench.h"

/// The input knows when its line was read, and tells its decoder about pauses.
namespace tribus::test::serial::input_pauses_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes sbus_wire(Pulse first) {
    ChannelFrame frame;
    frame.set(0, first);
    frame.frame_lost = false;
    frame.failsafe = false;
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = SbusEncoder().write(frame, wire, Instant{});
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}

/// Settings of an SBUS line: 120 us a byte.
InputSettings sbus_line() {
    InputSettings settings = sbus_input();
    settings.byte_time = 120us;
    return settings;
}

/// Returns the number of frames of an R7003SB, one every 14 ms, with its trailer 2 ms after each
/// (bolderflight/sbus, issue 79).
std::size_t frames_of_an_r7003sb(Input& input) {
    std::size_t frames = 0;
    for (int i = 0; i < 100; ++i) {
        frames += input.receive(sbus_wire(us(1000 + 5 * (i % 40))), at(14ms * i)) ? 1U : 0U;
        const Bytes trailer{0x00, 0x03, 0xC0, 0x33, 0x00};
        frames += input.receive(trailer, at(14ms * i + 2600us)) ? 1U : 0U;
    }
    return frames;
}

TEST(InputPauses, AFrameBehindAPauseComesWhateverStoodBeforeIt) {
    Input input(sbus_line(), 0);
    EXPECT_EQ(frames_of_an_r7003sb(input), 100U);
    EXPECT_EQ(input.control().channel(0), us(1095));
    EXPECT_EQ(input.control().received, at(99 * 14ms));
}

TEST(InputPauses, WhereTimesSayNothingContentAloneDecides) {
    Input input(sbus_input(), 0);
    EXPECT_EQ(frames_of_an_r7003sb(input), 0U);
}

TEST(InputPauses, TheFrameThatAPauseProvesIsAsOldAsItsBytes) {
    Input input(sbus_line(), 0);
    EXPECT_FALSE(input.receive(sbus_wire(us(1100)), at(5ms)));
    EXPECT_TRUE(input.receive(Bytes{0x0F}, at(19ms)));
    EXPECT_EQ(input.control().channel(0), us(1100));
    EXPECT_EQ(input.control().received, at(5ms));
}

TEST(InputPauses, FlagsAndFooterThatComeLaterAreOfAnotherFrame) {
    Input input(sbus_line(), 0);
    const Bytes whole = sbus_wire(us(1100));
    input.receive(whole, at(0ms));
    ASSERT_TRUE(input.receive(whole, at(10ms)));
    EXPECT_FALSE(input.receive(std::span(whole).first(23), at(24ms)));
    EXPECT_FALSE(input.receive(Bytes{0x0F, 0xE0}, at(38ms)));
    EXPECT_EQ(input.counts().frames, 2U);
}

TEST(InputPauses, TimeInWhichNobodyReadIsNoPause) {
    Input input(sbus_line(), 0);
    const Bytes whole = sbus_wire(us(1100));
    input.receive(whole, at(0ms));
    ASSERT_TRUE(input.receive(whole, at(10ms)));
    EXPECT_FALSE(input.receive(std::span(whole).first(10), at(24ms)));
    input.was_away(at(24ms), at(60ms));
    EXPECT_TRUE(input.receive(std::span(whole).subspan(10), at(61ms)));
}

// The first part of one frame and the rest of another are no frame.
TEST(InputPauses, HalfAFrameDoesNotOutliveItsDevice) {
    const Bytes before = sbus_wire(us(1100));
    const Bytes after = sbus_wire(us(1900));
    for (const Duration byte_time : {Duration(120us), Duration::zero()}) {
        for (std::size_t cut = 0; cut < kSbusFrameLength; ++cut) {
            InputSettings settings = sbus_line();
            settings.byte_time = byte_time;
            Input input(std::move(settings), 0);
            for (int i = 0; i < 5; ++i) {
                input.receive(before, at(14ms * i));
            }
            const auto frames = input.counts().frames;
            input.receive(std::span(before).first(cut), at(70ms));
            input.device_lost();
            EXPECT_FALSE(input.receive(std::span(after).subspan(cut), at(72ms))) << cut;
            EXPECT_EQ(input.counts().frames, frames) << cut;
            input.receive(after, at(86ms));
            input.receive(after, at(100ms));
            EXPECT_EQ(input.control().channel(0), us(1900)) << cut;
        }
    }
}

TEST(InputPauses, AReloadIsNoPause) {
    Input before(sbus_line(), 0);
    const Bytes whole = sbus_wire(us(1100));
    before.receive(whole, at(0ms));
    before.receive(std::span(whole).first(10), at(24ms));
    Input after(sbus_line(), 0);
    after.continue_from(before, {.from = 0, .same_channels = true}, at(25ms));
    EXPECT_TRUE(after.receive(std::span(whole).subspan(10), at(24ms + 15 * 120us)));
}

}  // namespace
}  // namespace tribus::test::serial::input_pauses_test
