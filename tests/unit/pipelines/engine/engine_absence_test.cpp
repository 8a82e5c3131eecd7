#include <array>
#include <span>

#include <gtest/gtest.h>

#include "tests/unit/pipelines/engine/engine_bench.h"

/// The thread does not run for a while: it is stopped or starved, or the machine sleeps.
namespace tribus::test::serial::engine_absence_test {
namespace {

constexpr FailsafeSettings kHoldsLong{.hold = 10s, .recover = 500ms};

/// Receives a frame of 1800 us that waited since 1000 ms.
void receive_what_waited(Bench& bench) {
    ChannelFrame frame;
    frame.set(0, us(1800));
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = IbusEncoder(14).write(frame, wire, Instant{});
    bench.engine().receive(0, std::span(wire).first(length), at(1000ms));
}

/// In control with 1200 us from 0 ms on. The thread stops at 1000 ms.
class Absence : public testing::Test {
  protected:
    explicit Absence(FailsafeSettings failsafe = kHoldsLong)
        : bench_(list(ibus_input()), list(sbus_output({0}, failsafe))) {
        bench_.ibus_run(0, at(0ms), at(1000ms), us(1200));
        bench_.loop().run_until(at(1000ms));
    }
    bool control(Instant when) {
        const SbusFrame frame = bench_.said(when);
        return !frame.frame_lost && !frame.failsafe;
    }

    Bench bench_;
};

TEST_F(Absence, ShorterThanTheTimeoutLeavesControlWithTheNewestFrame) {
    receive_what_waited(bench_);
    bench_.loop().come_back(at(1000ms), at(1080ms));
    EXPECT_TRUE(control(at(1080ms)));
    EXPECT_EQ(bench_.said(at(1080ms)).raw[0], raw_of(1800));
}

/// The frame may have come just after the thread stopped.
TEST_F(Absence, MakesAFrameThatWaitedAsOldAsItMayBe) {
    receive_what_waited(bench_);
    bench_.loop().come_back(at(1000ms), at(1080ms));
    EXPECT_FALSE(control(at(1100ms)));
}

TEST_F(Absence, AsLongAsTheTimeoutGivesNoControlToWhatWaited) {
    receive_what_waited(bench_);
    bench_.loop().come_back(at(1000ms), at(1100ms));
    EXPECT_FALSE(control(at(1100ms)));
}

TEST_F(Absence, AsLongAsTheTimeoutAsksForRecoverAlthoughValuesAreStillHeld) {
    bench_.loop().come_back(at(1000ms), at(1100ms));
    bench_.ibus_run(0, at(1104ms), at(2000ms), us(1800));
    EXPECT_FALSE(control(at(1600ms)));
    EXPECT_TRUE(control(at(1620ms)));
}

TEST_F(Absence, IsProvedAwayOnceAndForAll) {
    bench_.loop().come_back(at(1000ms), at(1100ms));
    bench_.ibus_run(0, at(1104ms), at(2000ms), us(1800));
    // A pause that is bridged, as before.
    bench_.ibus_run(0, at(2200ms), at(2300ms), us(1800));
    EXPECT_TRUE(control(at(2220ms)));
}

/// A CAN socket tells the age of each frame. One that came just now proves nothing about the
/// others.
TEST_F(Absence, AsksForRecoverEvenOfALinkWhoseLatestFrameIsYoung) {
    bench_.ibus(0, at(1099ms), us(1800));
    bench_.loop().come_back(at(1000ms), at(1100ms));
    EXPECT_FALSE(control(at(1100ms)));
    bench_.ibus_run(0, at(1104ms), at(1300ms), us(1800));
    EXPECT_FALSE(control(at(1300ms)));
}

/// Held since 945 + 100 ms, where the latest frame before the stop was lost.
TEST(AbsenceAfterSilence, MakesHeldValuesNoYoungerThanTheirFrame) {
    Bench bench(list(ibus_input()),
                list(sbus_output({0}, FailsafeSettings{.hold = 500ms, .recover = 500ms})));
    bench.ibus_run(0, at(0ms), at(950ms), us(1200));
    bench.loop().run_until(at(1000ms));
    receive_what_waited(bench);
    bench.loop().come_back(at(1000ms), at(1200ms));
    EXPECT_FALSE(bench.said(at(1520ms)).failsafe);
    EXPECT_TRUE(bench.said(at(1560ms)).failsafe);
}

TEST_F(Absence, ShowsAsASilentWireUntilTheNextFrame) {
    receive_what_waited(bench_);
    bench_.loop().come_back(at(1000ms), at(1200ms));
    EXPECT_EQ(bench_.engine().inputs()[0].state().cause, LinkCause::wire_silent);
}

/// A rest of a frame whose beginning was thrown away is no frame, and neither is the reverse.
TEST_F(Absence, LetsNoFrameGoOnAcrossBytesThatWereThrownAway) {
    ChannelFrame frame;
    frame.set(0, us(1800));
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = IbusEncoder(14).write(frame, wire, Instant{});
    const auto bytes = std::span(wire).first(length);
    const std::uint64_t frames = bench_.engine().inputs()[0].counts().frames;
    bench_.engine().receive(0, bytes.first(20), at(1000ms));
    bench_.engine().bytes_discarded(0);
    bench_.engine().receive(0, bytes.subspan(20), at(1000ms));
    EXPECT_EQ(bench_.engine().inputs()[0].counts().frames, frames);
}

}  // namespace
}  // namespace tribus::test::serial::engine_absence_test
