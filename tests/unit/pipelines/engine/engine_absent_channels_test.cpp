#include <gtest/gtest.h>

#include "tests/support/ibus_frames.h"
#include "tests/unit/pipelines/engine/engine_bench.h"

/// Values of channels that nobody sent: the output's presets, 988 us on channel 3, else 1500.
namespace tribus::test::serial::engine_absent_channels_test {
namespace {

/// A frame of one channel (docs/protocols/ibus.md, "Variants": receivers may send any even length
/// from 6 on).
const Bytes kOneAt988 = servo_frame({0xDC, 0x03}, 0x40);

/// Returns the raw SBUS value in Betaflight's scale.
std::uint16_t wire_value(std::int64_t microseconds) {
    return SbusScale::named("betaflight")->encode(us(microseconds));
}

/// Sends `count` channels at 1200 us.
void send_channels(Bench& bench, std::size_t count, Instant from, Instant until) {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < count; ++channel) {
        frame.set(channel, us(1200));
    }
    for (Instant when = from; when < until; when += 8ms) {
        bench.send(IbusEncoder(count), 0, when, frame);
    }
}
void fourteen(Bench& bench, Instant from, Instant until) {
    send_channels(bench, 14, from, until);
}

TEST(AbsentChannels, AreThePresetsOfTheOutput) {
    OutputSettings output = sbus_output({0});
    output.failsafe.presets[15] = us(1700);
    output.failsafe.presets[17] = us(2000);
    Bench bench(list(ibus_input()), list(std::move(output)));
    fourteen(bench, at(0ms), at(1s));
    const SbusFrame said = bench.said(at(1s));
    EXPECT_FALSE(said.failsafe || said.frame_lost);
    EXPECT_EQ(said.raw[13], wire_value(1200));
    EXPECT_EQ(said.raw[14], wire_value(1500));
    EXPECT_EQ(said.raw[15], wire_value(1700));
    EXPECT_FALSE(said.channel_17);
    EXPECT_TRUE(said.channel_18);
}

TEST(AbsentChannels, InASingleFrameDoNotMoveTheThrottle) {
    Bench bench(list(ibus_input()), list(sbus_output({0})));
    fourteen(bench, at(0ms), at(1s));
    bench.loop().receive(input_station(0), kOneAt988, at(1s));
    fourteen(bench, at(1008ms), at(2s));
    bench.said(at(2s));
    for (const Seen& seen : bench.seen()) {
        if (seen.at > at(600ms)) {
            EXPECT_TRUE(seen.frame.failsafe || seen.frame.raw[2] == wire_value(1200))
                << (seen.at - at(0ms)) / 1ms << " ms";
        }
    }
}

TEST(AbsentChannels, AreALossAndThenPresetsForASenderThatSendsOneForGood) {
    InputSettings input = ibus_input();
    input.supervision.fewer_channels_after = 500ms;
    Bench bench(list(std::move(input)), list(sbus_output({0})));
    fourteen(bench, at(0ms), at(1s));
    for (Instant when = at(1s); when < at(3s); when += 8ms) {
        bench.loop().receive(input_station(0), kOneAt988, when);
    }
    EXPECT_TRUE(bench.said(at(1200ms)).frame_lost);
    EXPECT_TRUE(bench.said(at(1450ms)).failsafe);
    const SbusFrame later = bench.said(at(1600ms));
    EXPECT_FALSE(later.failsafe || later.frame_lost);
    EXPECT_EQ(later.raw[0], wire_value(988));
    EXPECT_EQ(later.raw[2], wire_value(988));
    EXPECT_EQ(later.raw[3], wire_value(1500));
}

TEST(AbsentChannels, AreThePresetOfTheChannelThatAMapMakesFromThem) {
    OutputSettings output = sbus_output({0});
    output.channels = {{.output = 2, .source = FromChannel{16}}};
    Bench bench(list(ibus_input()), list(std::move(output)));
    fourteen(bench, at(0ms), at(1s));
    EXPECT_EQ(bench.said(at(1s)).raw[2], wire_value(988));
}

TEST(AbsentChannels, ThatAMapNamesAreToldOfAndOthersNot) {
    OutputSettings output = sbus_output({0});
    output.channels = {{.output = 2, .source = FromChannel{16}},
                       {.output = 3, .source = FromChannel{0}}};
    output.mapped_channels = 0b1100;
    Bench bench(list(ibus_input()), list(std::move(output)));
    EXPECT_EQ(bench.engine().outputs()[0].state(at(0ms)).by_preset, 0U);
    fourteen(bench, at(0ms), at(1s));
    bench.said(at(1s));
    EXPECT_EQ(bench.engine().outputs()[0].state(at(1s)).by_preset, 0b0100U);
    send_channels(bench, 18, at(1s), at(2s));
    bench.said(at(2s));
    EXPECT_EQ(bench.engine().outputs()[0].state(at(2s)).by_preset, 0U);
}

}  // namespace
}  // namespace tribus::test::serial::engine_absent_channels_test
