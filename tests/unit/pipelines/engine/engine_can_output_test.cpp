#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "tests/unit/pipelines/engine/can_bench.h"

namespace tribus::test::engine_can_output_test {
namespace {

using namespace on_can;

using namespace std::chrono_literals;

TEST(EngineCanOutput, HandsItsFramesOutOnce) {
    Engine engine(list(can_input()), list(can_output()));
    engine.start(at(0ms));
    engine.poll(at(0ms));
    const Transmission sent = engine.output(0).take();
    EXPECT_TRUE(sent.bytes().empty());
    EXPECT_EQ(sent.can_frames().size(), 5U);
    EXPECT_TRUE(engine.output(0).take().empty());
}

TEST(EngineCanOutput, SaysFailsafeInEveryFrameBeforeTheFirstGoodInput) {
    Bench bench(list(can_output()));
    const Seen seen = bench.said(at(10ms));
    ASSERT_EQ(seen.frames.size(), 5U);
    for (std::size_t part = 0; part < 4; ++part) {
        const CanChannelsQuad quad = parse_can_quad(seen.frames[part].bytes());
        EXPECT_TRUE(quad.status.failsafe && quad.status.frame_lost) << part;
    }
    const CanChannelsTail tail = parse_can_tail(seen.frames[4].bytes());
    EXPECT_TRUE(tail.status.failsafe && tail.status.frame_lost);
    EXPECT_EQ(tail.origin.age, 0xFF) << "presets have no age";
}

TEST(EngineCanOutput, TellsTheAgeThatValuesHaveWhenItSendsThem) {
    Bench bench(list(can_output()));
    bench.snapshots(at(0ms), at(100ms));
    bench.snapshot(at(105ms), 900, 20ms);
    // 20 ms at the arrival at 105 ms plus 5 ms until 110 ms, in steps of 0.25 ms.
    EXPECT_EQ(parse_can_tail(bench.said(at(110ms)).frames.at(4).bytes()).origin.age, 100);
    EXPECT_EQ(parse_can_tail(bench.said(at(130ms)).frames.at(4).bytes()).origin.age, 180);
}

TEST(EngineCanOutput, HeldValuesAreMarkedAndKeepAgeing) {
    Bench bench(list(can_output()));
    bench.snapshots(at(0ms), at(100ms));
    const Seen held = bench.said(at(145ms + kPeriod));
    EXPECT_EQ(parse_can_tail(held.frames.at(4).bytes()).origin.age, 220) << "95 to 150 ms";
    EXPECT_FALSE(held.frame_lost());
    EXPECT_TRUE(bench.said(at(200ms)).frame_lost());
    EXPECT_EQ(parse_can_tail(bench.said(at(200ms)).frames.at(4).bytes()).origin.age, 0xFE)
        << "as old as can be told";
}

TEST(EngineCanOutput, TheEndOfTheProgramSendsThreeFailsafeSnapshotsAndNothingMore) {
    Bench bench(list(can_output()));
    bench.snapshots(at(0ms), at(100ms));
    bench.run_until(at(100ms));
    const std::size_t before = bench.seen().size();
    bench.loop().end(at(105ms));
    ASSERT_EQ(bench.seen().size(), before + 3);
    for (std::size_t i = before; i < bench.seen().size(); ++i) {
        ASSERT_EQ(bench.seen()[i].frames.size(), 5U);
        EXPECT_TRUE(bench.seen()[i].failsafe());
    }
}

/// Outputs that send only named values are like this.
TEST(EngineCanOutput, WithoutAnInputItSpeaksEachPeriodAndSaysNoFailsafe) {
    OutputSettings alone = can_output();
    alone.selection.inputs.clear();
    Engine engine({}, list(std::move(alone)));
    engine.start(at(0ms));
    for (int period = 0; period < 20; ++period) {
        EXPECT_EQ(engine.poll(at(period * kPeriod)), at((period + 1) * kPeriod));
        const Transmission sent = engine.output(0).take();
        ASSERT_EQ(sent.can_frames().size(), 5U) << period;
        const CanChannelsQuad quad = parse_can_quad(sent.can_frames()[0].bytes());
        EXPECT_FALSE(quad.status.failsafe || quad.status.frame_lost) << period;
    }
    EXPECT_EQ(engine.output(0).stage(), OutputStage::control);
    EXPECT_EQ(engine.output(0).state(at(200ms)).input, kNoInput);
    engine.end(at(205ms));
    engine.poll(at(205ms));
    EXPECT_TRUE(engine.output(0).take().empty());
}

TEST(EngineCanOutput, ASerialAndACanOutputOfOnePipelineAlwaysAgree) {
    Bench bench(list(sbus_output(), can_output()));
    bench.snapshots(at(0ms), at(300ms));
    bench.marked_snapshot(at(305ms), true, false);
    bench.snapshots(at(310ms), at(400ms));
    bench.snapshots(at(1000ms), at(1700ms));
    bench.run_until(at(2500ms));
    ASSERT_EQ(bench.seen(0).size(), bench.seen(1).size());
    CanChannelsDecoder decoder(kOutputFormat);
    std::size_t compared = 0;
    for (std::size_t i = 0; i < bench.seen(0).size(); ++i) {
        const Seen& can = bench.seen(1)[i];
        ASSERT_EQ(can.at, bench.seen(0)[i].at);
        for (const ChannelFrame& snapshot : feed(decoder, can.frames, can.at)) {
            std::array<std::uint8_t, kLongestSerialFrame> wire{};
            const std::size_t length = SbusEncoder().write(snapshot, wire, Instant{});
            ASSERT_EQ(std::vector(wire.begin(), wire.begin() + static_cast<long>(length)),
                      bench.seen(0)[i].bytes)
                << "at " << (can.at - at(0ms)).count() << " ns";
            ++compared;
        }
    }
    // All except the first two, which no receiver publishes.
    EXPECT_EQ(compared, bench.seen(0).size() - 2);
}

/// A frame of another node with the first id of the output.
CanFrame foreign_frame(std::uint32_t id = kOutputFormat.base_id) {
    CanFrame frame;
    frame.id = id;
    frame.length = 8;
    return frame;
}

/// Sends as many foreign frames as distinguish a sender from a stray frame.
void foreign_frames(Bench& bench, Instant when, std::size_t output = 0,
                    std::uint32_t id = kOutputFormat.base_id) {
    for (int i = 0; i < 3; ++i) {
        bench.loop().receive({StationKind::output, output}, foreign_frame(id), when);
    }
}

TEST(EngineForeignSender, TwoFramesOnlyCount) {
    Bench bench(list(can_output()));
    bench.snapshots(at(0ms), at(200ms));
    bench.loop().receive({StationKind::output, 0}, foreign_frame(), at(205ms));
    bench.loop().receive({StationKind::output, 0}, foreign_frame(), at(205ms));
    EXPECT_FALSE(bench.said(at(210ms)).failsafe());
    EXPECT_EQ(bench.output_counts().foreign_frames, 2U);
}

TEST(EngineForeignSender, FramesASecondApartAreNoSender) {
    Bench bench(list(can_output()));
    for (int i = 1; i <= 5; ++i) {
        bench.snapshots(at((i - 1) * 1s), at(i * 1s));
        bench.loop().receive({StationKind::output, 0}, foreign_frame(), at(i * 1s));
    }
    EXPECT_EQ(bench.output_counts().failsafe_entries, 0U);
}

TEST(EngineForeignSender, PutsTheOutputIntoFailsafeWithItsNextSnapshotAndWithoutHold) {
    Bench bench(list(can_output()));
    bench.snapshots(at(0ms), at(200ms));
    EXPECT_FALSE(bench.said(at(200ms)).failsafe());
    foreign_frames(bench, at(205ms));
    EXPECT_TRUE(bench.said(at(210ms)).failsafe());
    EXPECT_EQ(bench.output_counts().foreign_frames, 3U);
    EXPECT_EQ(bench.output_counts().failsafe_entries, 1U);
}

TEST(EngineForeignSender, KeepsItThereForASecondAfterItsLastFrame) {
    Bench bench(list(can_output({.recover = 0ms})));
    bench.snapshots(at(0ms), at(205ms));
    foreign_frames(bench, at(205ms));
    bench.snapshots(at(210ms), at(700ms));
    bench.loop().receive({StationKind::output, 0}, foreign_frame(), at(700ms));
    bench.snapshots(at(700ms), at(2s));
    EXPECT_TRUE(bench.said(at(1690ms)).failsafe());
    EXPECT_FALSE(bench.said(at(1700ms)).failsafe());
}

TEST(EngineForeignSender, AfterThatSecondControlWaitsForRecover) {
    Bench bench(list(can_output({.recover = 500ms})));
    bench.snapshots(at(0ms), at(200ms));
    foreign_frames(bench, at(200ms));
    bench.snapshots(at(200ms), at(2s));
    EXPECT_TRUE(bench.said(at(1690ms)).failsafe());
    EXPECT_FALSE(bench.said(at(1700ms)).failsafe());
    EXPECT_EQ(bench.output_counts().recoveries, 1U);
}

TEST(EngineForeignSender, GetsTheBusForItselfIfTheActionIsSilence) {
    Bench bench(list(can_output({.action = FailsafeAction::silence})));
    bench.snapshots(at(0ms), at(200ms));
    foreign_frames(bench, at(205ms));
    const std::size_t before = bench.seen().size();
    bench.snapshots(at(210ms), at(1200ms));
    bench.run_until(at(1200ms));
    EXPECT_EQ(bench.seen().size(), before);
}

TEST(EngineForeignSender, WithForeignSenderIgnoreOnlyCounts) {
    OutputSettings settings = can_output();
    settings.yield_to_foreign_sender = false;
    Bench bench(list(std::move(settings)));
    bench.snapshots(at(0ms), at(200ms));
    foreign_frames(bench, at(205ms));
    EXPECT_FALSE(bench.said(at(210ms)).failsafe());
    EXPECT_EQ(bench.output_counts().foreign_frames, 3U);
    EXPECT_EQ(bench.output_counts().failsafe_entries, 0U);
}

TEST(EngineForeignSender, AnyOfTheIdsOfTheOutputAndNoOtherIsMeant) {
    Bench bench(list(can_output()));
    bench.snapshots(at(0ms), at(200ms));
    CanFrame extended = foreign_frame();
    extended.extended = true;
    for (const CanFrame& other : {foreign_frame(0x3FF), foreign_frame(0x405), extended}) {
        bench.loop().receive({StationKind::output, 0}, other, at(205ms));
    }
    EXPECT_FALSE(bench.said(at(210ms)).failsafe());
    EXPECT_EQ(bench.output_counts().foreign_frames, 0U);
    foreign_frames(bench, at(215ms), 0, 0x404);
    EXPECT_TRUE(bench.said(at(220ms)).failsafe());
}

TEST(EngineForeignSender, DoesNotReachTheOtherOutputsOfThePipeline) {
    Bench bench(list(can_output(), sbus_output()));
    bench.snapshots(at(0ms), at(200ms));
    foreign_frames(bench, at(205ms), 0);
    foreign_frames(bench, at(205ms), 1);
    EXPECT_TRUE(bench.said(at(210ms), 0).failsafe());
    EXPECT_FALSE(bench.said(at(210ms), 1).failsafe());
}

}  // namespace
}  // namespace tribus::test::engine_can_output_test
