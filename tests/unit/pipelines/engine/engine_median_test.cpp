#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

#include "tests/unit/pipelines/engine/engine_bench.h"

/// Which inputs count in a median, and how long one that failed is left out.
namespace tribus::test::serial::engine_median_test {
namespace {

/// Receivers of the same sticks that feed one output by their median.
class Receivers {
  public:
    explicit Receivers(std::size_t count) : bench_(inputs_of(count), list(output_of(count))) {}

    /// Each receiver sends its value on channel 1 every 8 ms until `until`. Frames of `lost` are
    /// marked frame-lost.
    void run(Duration until, std::vector<int> values, std::size_t lost = SIZE_MAX) {
        for (; next_ < at(until); next_ += 8ms) {
            for (std::size_t input = 0; input < values.size(); ++input) {
                bench_.sbus(input, next_ + static_cast<std::int64_t>(input) * 1ms,
                            us(values[input]), input == lost, false);
            }
        }
        bench_.said(at(until));
    }
    SbusFrame said(Duration when) { return bench_.said(at(when)); }
    const InputSelector& selector() { return bench_.engine().outputs()[0].selector(); }

  private:
    static std::vector<InputSettings> inputs_of(std::size_t count) {
        std::vector<InputSettings> inputs;
        for (std::size_t input = 0; input < count; ++input) {
            inputs.push_back(sbus_input());
        }
        return inputs;
    }
    static OutputSettings output_of(std::size_t count) {
        OutputSettings output = sbus_output({});
        output.selection.mode = SelectionMode::median;
        for (std::size_t input = 0; input < count; ++input) {
            output.selection.inputs.push_back(input);
        }
        return output;
    }

    Bench bench_;
    Instant next_ = at(1ms);
};

TEST(Vote, AmongFourNeedsMoreThanTwoThatAgreeToMakeTheOthersLiars) {
    Receivers four(4);
    four.run(5s, {1400, 1520, 1580, 1900});  // the median is 1550
    EXPECT_EQ(four.selector().outvoted_count(), 0U);
}

TEST(Vote, IsNotGivenToOldValuesBesideFreshOnes) {
    Receivers three(3);
    three.run(500ms, {1100, 1600, 1500});
    EXPECT_EQ(three.said(500ms).raw[0], raw_of(1500));
    three.run(560ms, {1100, 1600, 1500}, 0);
    EXPECT_EQ(three.said(560ms).raw[0], raw_of(1600)) << "of two that differ, the preferred one";
    EXPECT_FALSE(three.said(560ms).frame_lost);
}

TEST(Vote, IsNotLostByShortDisagreementsHoweverMany) {
    Receivers three(3);
    Duration until = 1s;
    three.run(until, {1500, 1500, 1500});
    for (int times = 0; times < 5; ++times) {
        three.run(until += 300ms, {1500, 1500, 1700});
        three.run(until += 300ms, {1500, 1500, 1500});
    }
    EXPECT_EQ(three.selector().outvoted_count(), 0U);
}

TEST(Vote, ComesBackOnlyAfterHalfASecondOfAgreement) {
    Receivers three(3);
    three.run(1s, {1500, 1500, 1500});
    three.run(2s, {1500, 1500, 1700});
    EXPECT_TRUE(three.selector().outvoted(2));
    three.run(2480ms, {1500, 1500, 1500});
    EXPECT_TRUE(three.selector().outvoted(2));
    three.run(2540ms, {1500, 1500, 1500});
    EXPECT_FALSE(three.selector().outvoted(2));
}

TEST(Handover, ForgetsThePositionOfAChannelThatWasLost) {
    OutputSettings output = sbus_output({0, 1});
    output.selection.handover = HandoverSettings{.input = 0, .channel = 2};
    Bench bench(list(ibus_input(), ibus_input()), list(std::move(output)));
    const auto run = [&](Duration from, Duration until, int handover) {
        for (Instant when = at(from); when < at(until); when += 8ms) {
            if (handover != 0) {
                bench.ibus(0, when, us(1100), us(handover));
            }
            bench.ibus(1, when + 1ms, us(1200));
        }
        return bench.said(at(until)).raw[0];
    };
    EXPECT_EQ(run(1ms, 500ms, 1490), raw_of(1100));
    EXPECT_EQ(run(501ms, 1s, 0), raw_of(1200));
    EXPECT_EQ(run(1001ms, 2s, 1510), raw_of(1200)) << "just above the boundary";
}

}  // namespace
}  // namespace tribus::test::serial::engine_median_test
