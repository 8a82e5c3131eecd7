#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/gpio_bank.h"
#include "tests/lab/gpio_trace.h"
#include "tests/lab/shell.h"
#include "tests/support/heap_trap.h"
#include "transports/links/gpio/gpio_line.h"

/// Effects of an output on its line.
namespace tribus::test::gpio_output_test {
namespace {

TEST(GpioOutput, SetsTheLevelOfItsLineAlone) {
    const GpioBank bank;
    const auto output = GpioOutput::open({bank.chip(), 5U}, false, false);
    ASSERT_TRUE(output) << output.error();
    EXPECT_TRUE((*output)->set(true));
    EXPECT_EQ(bank.level(5), "1");
    EXPECT_EQ(bank.level(4), "0");
    EXPECT_TRUE((*output)->set(false));
    EXPECT_EQ(bank.level(5), "0");
}

TEST(GpioOutput, IsLowWhenActiveIfSoAsked) {
    const GpioBank bank;
    const auto output = GpioOutput::open({bank.chip(), 5U}, true, false);
    ASSERT_TRUE(output) << output.error();
    EXPECT_EQ(bank.level(5), "1");
    EXPECT_TRUE((*output)->set(true));
    EXPECT_EQ(bank.level(5), "0");
    EXPECT_TRUE((*output)->set(false));
    EXPECT_EQ(bank.level(5), "1");
}

struct Start {
    bool active_low;
    bool active_at_start;
    const char* level;
};

class GpioOutputStart : public testing::TestWithParam<Start> {};

TEST_P(GpioOutputStart, IsAtItsLevelFromTheFirstMoment) {
    const auto [active_low, active_at_start, level] = GetParam();
    const GpioBank bank;
    bank.pull(3, std::string(level) == "0");
    const LevelTrace trace;
    const auto output = GpioOutput::open({bank.chip(), 3U}, active_low, active_at_start);
    ASSERT_TRUE(output) << output.error();
    EXPECT_EQ(trace.levels(), std::vector<std::string>{level});
    EXPECT_EQ(bank.level(3), level);
}

INSTANTIATE_TEST_SUITE_P(Levels, GpioOutputStart,
                         testing::Values(Start{false, false, "0"}, Start{false, true, "1"},
                                         Start{true, false, "1"}, Start{true, true, "0"}));

TEST(GpioOutput, IsSetWithoutHeap) {
    const GpioBank bank;
    const auto output = GpioOutput::open({bank.chip(), 5U}, false, false);
    ASSERT_TRUE(output) << output.error();
    const HeapTrap heap;
    const bool set = (*output)->set(true) && (*output)->set(false);
    EXPECT_EQ(heap.allocations(), 0U);
    EXPECT_TRUE(set);
}

TEST(GpioOutput, GivesItsLineBackAtItsEnd) {
    const GpioBank bank;
    {
        const auto output = GpioOutput::open({bank.chip(), 5U}, false, true);
        ASSERT_TRUE(output) << output.error();
        EXPECT_EQ(bank.level(5), "1");
    }
    EXPECT_EQ(bank.level(5), "0");
    const auto input = GpioInput::open({bank.chip(), 5U}, false, GpioBias::as_is);
    EXPECT_TRUE(input) << input.error();
}

TEST(GpioOutput, SaysThatItsChipIsGone) {
    GpioBank bank;
    const auto output = GpioOutput::open({bank.chip(), 5U}, false, true);
    ASSERT_TRUE(output) << output.error();
    bank.remove();
    EXPECT_FALSE((*output)->set(false));
    EXPECT_FALSE((*output)->set(true));
}

TEST(GpioOutput, IsOpenedAnewOnAChipThatCameBack) {
    GpioBank bank;
    {
        const auto before = GpioOutput::open({bank.chip(), 5U}, false, true);
        ASSERT_TRUE(before) << before.error();
        bank.remove();
        EXPECT_FALSE((*before)->set(true));
    }
    bank.put_back();
    const auto output = GpioOutput::open({bank.chip(), 5U}, false, true);
    ASSERT_TRUE(output) << output.error();
    EXPECT_EQ(bank.level(5), "1");
}

}  // namespace
}  // namespace tribus::test::gpio_output_test
