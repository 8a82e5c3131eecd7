#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "tests/unit/pipelines/engine/can_bench.h"

namespace tribus::test::engine_can_test {
namespace {

using namespace on_can;

using namespace std::chrono_literals;

std::uint16_t raw_of(Pulse pulse) {
    // SBUS in Betaflight's scale: 880 us and 5/8 us a step.
    return static_cast<std::uint16_t>((pulse.eighths() - 880 * 8 + 2) / 5);
}

/// Classic frames and FD frames, with a tail and without.
class EngineCanInput : public testing::TestWithParam<CanChannelsFormat> {};

INSTANTIATE_TEST_SUITE_P(Formats, EngineCanInput, testing::ValuesIn(kCanFormats));

TEST_P(EngineCanInput, TheValuesOfASnapshotComeOutOfASerialOutput) {
    Bench bench(list(sbus_output()), GetParam());
    bench.snapshots(at(0ms), at(100ms));
    const Seen seen = bench.said(at(100ms));
    const ChannelFrame sent = numbered_snapshot(bench.number());
    EXPECT_FALSE(seen.failsafe());
    EXPECT_FALSE(seen.frame_lost());
    for (std::size_t channel = 0; channel < 16; ++channel) {
        EXPECT_EQ(seen.sbus().raw[channel], raw_of(*sent.channel(channel))) << channel;
    }
}

TEST_P(EngineCanInput, SilenceOfTheBusEndsInFrameLostAtTheTimeoutAndThenInFailsafe) {
    Bench bench(list(sbus_output()), GetParam());
    bench.snapshots(at(0ms), at(200ms));
    // The last snapshot at 195 ms: lost at 295 ms, held until 595 ms. A frame counts for 10 ms.
    EXPECT_FALSE(bench.said(at(280ms)).frame_lost());
    EXPECT_TRUE(bench.said(at(290ms)).frame_lost());
    EXPECT_FALSE(bench.said(at(580ms)).failsafe());
    EXPECT_TRUE(bench.said(at(590ms)).failsafe());
}

TEST_P(EngineCanInput, AfterFailsafeControlReturnsOnlyAfterAnUnbrokenRun) {
    Bench bench(list(sbus_output()), GetParam());
    bench.snapshots(at(0ms), at(200ms));
    // Two snapshots prove that the sender lives, so the run begins at 1025 ms.
    bench.snapshots(at(1000ms), at(1600ms));
    EXPECT_TRUE(bench.said(at(1520ms)).failsafe());
    EXPECT_FALSE(bench.said(at(1530ms)).failsafe());
}

TEST_P(EngineCanInput, AFailsafeFlagOfTheSenderIsALossAtOnce) {
    Bench bench(list(sbus_output()), GetParam());
    bench.snapshots(at(0ms), at(200ms));
    bench.marked_snapshot(at(205ms), true, true);
    const Seen held = bench.said(at(210ms));
    EXPECT_TRUE(held.frame_lost());
    EXPECT_EQ(held.sbus().raw[0], raw_of(*numbered_snapshot(bench.number()).channel(0)));
    EXPECT_TRUE(bench.said(at(505ms)).failsafe());
}

TEST_P(EngineCanInput, AFailsafeFlagBehindTheTimeoutDoesNotBeginTheHoldTimeAgain) {
    Bench bench(list(sbus_output()), GetParam());
    bench.snapshots(at(0ms), at(200ms));
    // A sender whose own input was lost: it holds for 300 ms, then marks failsafe.
    for (Instant when = at(205ms); when < at(800ms); when += kPeriod) {
        bench.marked_snapshot(when, true, when >= at(505ms));
    }
    EXPECT_FALSE(bench.said(at(580ms)).failsafe());
    EXPECT_TRUE(bench.said(at(590ms)).failsafe()) << "195 ms, timeout 100, hold 300";
}

TEST_P(EngineCanInput, AFrameLostMarkOfTheSenderPassesWhileTheLinkIsUp) {
    Bench bench(list(sbus_output()), GetParam());
    bench.snapshots(at(0ms), at(200ms));
    bench.marked_snapshot(at(205ms), true, false);
    const Seen seen = bench.said(at(210ms));
    EXPECT_TRUE(seen.frame_lost());
    EXPECT_FALSE(seen.failsafe());
    EXPECT_EQ(bench.input().counts().frame_lost_frames, 1U);
}

/// Formats that carry the age of the values.
class EngineCanAge : public testing::TestWithParam<CanChannelsFormat> {
  protected:
    EngineCanAge() : bench(list(sbus_output()), GetParam()) { bench.snapshots(at(0ms), at(200ms)); }
    Bench bench;
};

INSTANTIATE_TEST_SUITE_P(Formats, EngineCanAge,
                         testing::Values(CanChannelsFormat{},
                                         CanChannelsFormat{.crc = CanChannelsCrc::p01},
                                         CanChannelsFormat{.fd = true}));

TEST_P(EngineCanAge, ValuesThatWere60MsOldWhenSentAreLost40MsAfter) {
    bench.snapshot(at(205ms), 900, 60ms);
    EXPECT_EQ(bench.input().link().lost_at(), at(245ms));
    EXPECT_FALSE(bench.said(at(230ms)).frame_lost());
    EXPECT_TRUE(bench.said(at(240ms)).frame_lost());
}

TEST(EngineCanFdAge, ValuesThatWere90MsOldWhenSentAreLost10MsAfter) {
    Bench bench(list(sbus_output()), {.fd = true});
    bench.snapshots(at(0ms), at(200ms));
    bench.snapshot(at(205ms), 900, 90ms);
    EXPECT_TRUE(bench.input().link().alive(at(214ms)));
    EXPECT_FALSE(bench.input().link().alive(at(215ms)));
}

TEST(EngineCanFdAge, ValuesAsOldAsTheTimeoutNeverGetControl) {
    Bench bench(list(sbus_output()), {.fd = true});
    for (Instant when = at(5ms); when < at(700ms); when += kPeriod) {
        bench.snapshot(when, 900, kTimeout);
    }
    bench.run_until(at(700ms));
    EXPECT_GT(bench.input().counts().frames, 60U);
    EXPECT_TRUE(std::ranges::all_of(bench.seen(), &Seen::failsafe));
}

TEST(EngineCanFdAge, ASenderThatGoesOnWithOldValuesIsLostByTheirAge) {
    Bench bench(list(sbus_output()), {.fd = true});
    bench.snapshots(at(0ms), at(200ms));
    // Fresh counters and checksums every 10 ms, but always the values of 205 ms.
    for (Instant when = at(205ms); when < at(700ms); when += kPeriod) {
        bench.snapshot(when, 900, when - at(205ms));
    }
    EXPECT_FALSE(bench.said(at(290ms)).frame_lost());
    EXPECT_TRUE(bench.said(at(300ms)).frame_lost());
    EXPECT_TRUE(bench.said(at(600ms)).failsafe());
}

TEST(EngineCanClassicAge, BeyondThe63MsThatItTellsValuesAreAsOldAsThoseBefore) {
    Bench bench(list(sbus_output()));
    bench.snapshots(at(0ms), at(200ms));
    bench.snapshot(at(205ms), 900, 60ms);
    bench.snapshot(at(245ms), 900, 100ms);
    bench.snapshot(at(345ms), 900, 200ms);
    EXPECT_EQ(bench.input().link().lost_at(), at(145ms) + kTimeout);
}

TEST(EngineCanClassicAge, BelowThe63MsThatItTellsIsBelievedAgainAfterOlderValues) {
    Bench bench(list(sbus_output()));
    bench.snapshots(at(0ms), at(200ms));
    bench.snapshot(at(245ms), 900, 100ms);
    bench.snapshot(at(255ms), 901, 10ms);
    EXPECT_EQ(bench.input().link().lost_at(), at(245ms) + kTimeout);
}

TEST(EngineCanWithoutAge, ValuesCountFromTheirArrival) {
    Bench bench(list(sbus_output()), {.channels = 16});
    bench.snapshots(at(0ms), at(200ms));
    bench.snapshot(at(205ms), 900, 90ms);
    EXPECT_EQ(bench.input().link().lost_at(), at(305ms));
}

class EngineCanIds : public testing::Test {
  protected:
    EngineCanIds() { bench.snapshots(at(0ms), at(100ms)); }

    void expect_nothing_counted_for(CanFrame frame) {
        const InputCounts before = bench.input().counts();
        bench.loop().receive(input_station(0), frame, at(100ms));
        EXPECT_EQ(bench.input().counts().bytes, before.bytes);
        EXPECT_EQ(bench.input().counts().frames, before.frames);
        for (const NamedCount& cause : bench.input().decoder().rejected()) {
            EXPECT_EQ(cause.count, cause.name == "unconfirmed" ? 2U : 0U) << cause.name;
        }
    }
    CanFrame first_frame() {
        CanChannelsEncoder encoder;
        return can_frames(encoder, numbered_snapshot(1)).front();
    }
    Bench bench{list(sbus_output())};
};

TEST_F(EngineCanIds, AWantedFrameCountsItsBytesAndASnapshotAsOneFrame) {
    // Ten snapshots of five frames of eight bytes. The first two are not published.
    EXPECT_EQ(bench.input().counts().bytes, 400U);
    EXPECT_EQ(bench.input().counts().frames, 8U);
}

TEST_F(EngineCanIds, AFrameWithAnIdThatIsNotWantedCountsNothing) {
    CanFrame frame = first_frame();
    frame.id = 0x305;
    expect_nothing_counted_for(frame);
}

TEST_F(EngineCanIds, AnExtendedIdOfTheSameNumberIsAnotherId) {
    CanFrame frame = first_frame();
    frame.extended = true;
    expect_nothing_counted_for(frame);
}

TEST_F(EngineCanIds, AWantedFrameThatIsDamagedIsCountedByItsCauseAndGivesNoValues) {
    CanFrame frame = first_frame();
    frame.data[3] ^= 0x10;
    const InputCounts before = bench.input().counts();
    bench.loop().receive(input_station(0), frame, at(100ms));
    EXPECT_EQ(bench.input().counts().bytes, before.bytes + 8);
    EXPECT_EQ(bench.input().counts().frames, before.frames);
    const auto rejected = bench.input().decoder().rejected();
    const auto cause = std::ranges::find(rejected, "checksum", &NamedCount::name);
    ASSERT_NE(cause, rejected.end());
    EXPECT_EQ(cause->count, 1U);
}

TEST_F(EngineCanIds, InputsTellWhatTheyWantAndOutputsWhatTheySend) {
    Bench both(list(can_output(), sbus_output()), {.base_id = 0x300, .fd = true});
    ASSERT_EQ(both.input().wanted_ids().size(), 1U);
    EXPECT_EQ(both.input().wanted_ids()[0].id, 0x305U);
    EXPECT_TRUE(both.input().uses_fd());
    ASSERT_EQ(both.engine().outputs()[0].sent_ids().size(), 5U);
    EXPECT_EQ(both.engine().outputs()[0].sent_ids()[0].id, 0x400U);
    EXPECT_FALSE(both.engine().outputs()[0].uses_fd());
    EXPECT_TRUE(both.engine().outputs()[1].sent_ids().empty());
}

}  // namespace
}  // namespace tribus::test::engine_can_test
