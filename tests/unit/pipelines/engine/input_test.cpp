#include "pipelines/engine/input.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <vector>

#include "tests/unit/pipelines/engine/engine_bench.h"

/// A decoder holds back a frame that is not yet proved. The age of its values is nevertheless that
/// of its bytes.
namespace tribus::test::serial::input_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes wire_of(ByteEncoder&& encoder, Pulse first) {
    ChannelFrame frame;
    frame.set(0, first);
    frame.frame_lost = false;
    frame.failsafe = false;
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = encoder.write(frame, wire, Instant{});
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}
Bytes sbus_wire(Pulse first) {
    return wire_of(SbusEncoder(), first);
}

TEST(FrameAge, AFrameThatWaitedForItsProofIsAsOldAsItsBytes) {
    Input input(sbus_input(), 0);
    EXPECT_FALSE(input.receive(sbus_wire(us(1100)), at(5ms)));
    const Bytes proof = sbus_wire(us(1200));
    EXPECT_TRUE(input.receive(proof, at(65ms)));
    EXPECT_EQ(input.counts().frames, 2U);
    EXPECT_EQ(input.arrivals().interval(), 60ms);
    EXPECT_EQ(input.control().received, at(65ms));
}

TEST(FrameAge, AFrameOlderThanTheTimeoutIsALossThatIsOver) {
    Input input(sbus_input(), 0);
    input.receive(sbus_wire(us(1100)), at(5ms));
    input.receive(sbus_wire(us(1200)), at(150ms));
    EXPECT_TRUE(input.link().alive(at(150ms)));
    EXPECT_EQ(input.link().run_start(), at(150ms)) << "the first one was lost at 105 ms";
    EXPECT_FALSE(input.link().first_run());
}

TEST(FrameAge, AFrameBehindBytesThatWereJudgedWithItHasItsOwnTime) {
    Input input(sbus_input(), 0);
    // Looks like a frame until the bytes after it show that it is none. A true one begins inside
    // it.
    Bytes stream(4, 0x00);
    stream[0] = 0x0F;
    for (const Pulse first : {us(1100), us(1200)}) {
        const Bytes frame = sbus_wire(first);
        stream.insert(stream.end(), frame.begin(), frame.end());
    }
    for (std::size_t i = 0; i < stream.size(); ++i) {
        input.receive(std::span(stream).subspan(i, 1), at(1ms * i));
    }
    EXPECT_EQ(input.counts().frames, 2U);
    EXPECT_EQ(input.arrivals().interval(), 25ms);
    EXPECT_EQ(input.control().received, at(53ms));
}

TEST(FrameAge, AShortIbusFrameInsideWhatLookedLikeALongOneHasItsOwnTime) {
    Input input(ibus_input(), 0);
    // By its header a frame of 32 bytes, but it contains a frame of one channel. Other bytes end
    // the wait.
    const Bytes stream{0x20, 0x40, 0x06, 0x40, 0xDC, 0x05, 0xD8, 0xFE};
    EXPECT_FALSE(input.receive(stream, at(5ms)));
    EXPECT_TRUE(input.receive(Bytes(24, 0xFF), at(60ms)));
    EXPECT_EQ(input.control().channel(0), us(1500));
    EXPECT_EQ(input.control().received, at(5ms));
    EXPECT_TRUE(input.link().alive(at(104ms)));
    EXPECT_FALSE(input.link().alive(at(105ms)));
}

TEST(FrameAge, OutlastsAReloadBetweenAFrameAndItsProof) {
    Input before(sbus_input(), 0);
    before.receive(sbus_wire(us(1100)), at(5ms));
    Input after(sbus_input(), 0);
    after.continue_from(before, {.from = 0, .same_channels = true}, at(6ms));
    after.receive(sbus_wire(us(1200)), at(12ms));
    EXPECT_EQ(after.counts().frames, 2U);
    EXPECT_EQ(after.arrivals().interval(), 7ms);
}

}  // namespace
}  // namespace tribus::test::serial::input_test
