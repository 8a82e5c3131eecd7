#include "app/web/recordings/plot_curve.h"

#include <chrono>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::test::plot_curve_test {
namespace {

using namespace web;
using namespace std::chrono_literals;

Pulse us(int microseconds) {
    return Pulse::from_microseconds(microseconds);
}

/// `1500` or `1400..1600` for each column, `-` for an empty one.
std::string shown(const PlotCurve& curve) {
    std::string text;
    for (const PlotColumn& column : curve.columns()) {
        const auto least = std::to_string(column.least.whole_microseconds());
        const auto greatest = std::to_string(column.greatest.whole_microseconds());
        text += text.empty() ? "" : " ";
        text += column.empty() ? "-" : least == greatest ? least : least + ".." + greatest;
    }
    return text;
}

constexpr PlotSpan kSpan{.from = 100ms, .to = 200ms, .columns = 5};

TEST(PlotCurve, AValueLastsUntilTheNextOne) {
    PlotCurve curve(kSpan);
    curve.set(110ms, us(1500));
    curve.set(150ms, us(1700));
    curve.end(200ms);
    EXPECT_EQ(shown(curve), "1500 1500 1500..1700 1700 1700");
}

TEST(PlotCurve, AColumnHasTheLeastAndTheGreatestOfItsValues) {
    PlotCurve curve(kSpan);
    curve.set(121ms, us(1500));
    curve.set(122ms, us(1100));
    curve.set(122ms, us(1900));
    curve.set(122ms, us(1400));
    curve.end(123ms);
    EXPECT_EQ(shown(curve), "- 1100..1900 - - -") << "also of values of one instant";
}

TEST(PlotCurve, AColumnThatAValueOnlyTouchesWithItsEndIsEmpty) {
    PlotCurve curve(kSpan);
    curve.set(120ms, us(1500));
    curve.end(140ms);
    EXPECT_EQ(shown(curve), "- 1500 - - -");
}

TEST(PlotCurve, WhatLiesOutsideOfTheSpanIsLeftOutButLastsIntoIt) {
    PlotCurve curve(kSpan);
    curve.set(10ms, us(1000));
    curve.set(90ms, us(1500));
    curve.set(185ms, us(1600));
    curve.set(200ms, us(1999));
    curve.end(1h);
    EXPECT_EQ(shown(curve), "1500 1500 1500 1500 1500..1600");
}

TEST(PlotCurve, DoesNotOverflowWithALongRecording) {
    const PlotSpan span{.from = 0s, .to = kLongestPlot, .columns = kMostPlotColumns};
    EXPECT_EQ(span.column(kLongestPlot - 1ns), kMostPlotColumns - 1);
    EXPECT_EQ(span.column(kLongestPlot / 2), kMostPlotColumns / 2);
}

ChannelFrame frame(std::vector<int> values) {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < values.size(); ++channel) {
        frame.set(channel, us(values[channel]));
    }
    return frame;
}

TEST(PlotFrames, EndWhenNoFrameFollows) {
    PlotFrames frames(kSpan, 30ms);
    frames.take(100ms, frame({1500, 1600}));
    frames.take(115ms, frame({1510, 1600}));
    frames.take(185ms, frame({1520, 1600}));
    frames.finish(190ms);
    EXPECT_EQ(shown(*frames.channel(0)), "1500..1510 1510 1510 - 1520");
    EXPECT_EQ(shown(*frames.channel(1)), "1600 1600 1600 - 1600");
    EXPECT_EQ(frames.channel(2), nullptr);
}

TEST(PlotFrames, AChannelThatIsAbsentEnds) {
    PlotFrames frames(kSpan, 1s);
    frames.take(100ms, frame({1500, 1600}));
    frames.take(140ms, frame({1500}));
    frames.finish(200ms);
    EXPECT_EQ(shown(*frames.channel(0)), "1500 1500 1500 1500 1500");
    EXPECT_EQ(shown(*frames.channel(1)), "1600 1600 - - -");
}

TEST(PlotStates, AreSpellsWithinTheSpan) {
    PlotStates states(kSpan);
    states.set(10ms, "failsafe");
    states.set(90ms, "control");
    states.set(150ms, "control");
    states.set(160ms, "hold");
    states.set(250ms, "failsafe");
    states.finish(300ms);
    ASSERT_EQ(states.states().size(), 2U);
    EXPECT_EQ(states.states()[0].word, "control");
    EXPECT_EQ(states.states()[0].from, 100ms);
    EXPECT_EQ(states.states()[0].to, 160ms);
    EXPECT_EQ(states.states()[1].word, "hold");
    EXPECT_EQ(states.states()[1].to, 200ms);
}

TEST(PlotStates, AreCountedBeyondALimitForALinkThatFlaps) {
    PlotStates states({.from = 0s, .to = 1h, .columns = 1});
    for (int i = 0; i < 1000; ++i) {
        states.set(i * 1ms, i % 2 == 0 ? "control" : "hold");
    }
    states.finish(1h);
    EXPECT_EQ(states.states().size(), PlotStates::kMost);
    EXPECT_EQ(states.left_out(), 1000 - PlotStates::kMost);
}

}  // namespace
}  // namespace tribus::test::plot_curve_test
