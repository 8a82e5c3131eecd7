#include <poll.h>

#include <chrono>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

#include "tests/lab/gpio_bank.h"
#include "tests/support/heap_trap.h"
#include "transports/links/gpio/gpio_line.h"

/// State and events that an input reports of its line.
namespace tribus::test::gpio_input_test {
namespace {

/// Longer than any pause of the guest.
constexpr int kLongMilliseconds = 20000;
/// Enough time for an edge that is on its way.
constexpr int kShortMilliseconds = 200;

/// Returns the events that poll reports for the descriptor, or 0 if there are none.
int events_within(const GpioInput& input, int milliseconds) {
    pollfd line{.fd = input.descriptor(), .events = POLLIN, .revents = 0};
    return ::poll(&line, 1, milliseconds) > 0 ? line.revents : 0;
}

TEST(GpioInput, ReadsTheLevelOfItsLine) {
    const GpioBank bank;
    const auto input = GpioInput::open({bank.chip(), 2U}, false, GpioBias::as_is);
    ASSERT_TRUE(input) << input.error();
    EXPECT_EQ((*input)->read(), std::optional(false));
    bank.pull(2, true);
    EXPECT_EQ((*input)->read(), std::optional(true));
    bank.pull(2, false);
    EXPECT_EQ((*input)->read(), std::optional(false));
}

TEST(GpioInput, IsActiveWhenLowIfSoAsked) {
    const GpioBank bank;
    const auto input = GpioInput::open({bank.chip(), 2U}, true, GpioBias::as_is);
    ASSERT_TRUE(input) << input.error();
    EXPECT_EQ((*input)->read(), std::optional(true));
    bank.pull(2, true);
    EXPECT_EQ((*input)->read(), std::optional(false));
}

TEST(GpioInput, WakesAtEachEdgeUntilItIsRead) {
    const GpioBank bank;
    const auto input = GpioInput::open({bank.chip(), 2U}, false, GpioBias::as_is);
    ASSERT_TRUE(input) << input.error();
    EXPECT_EQ(events_within(**input, kShortMilliseconds), 0);
    for (const bool level : {true, false, true}) {
        bank.pull(2, level);
        EXPECT_EQ(events_within(**input, kLongMilliseconds), POLLIN);
        EXPECT_EQ((*input)->read(), std::optional(level));
        EXPECT_EQ(events_within(**input, kShortMilliseconds), 0);
    }
}

TEST(GpioInput, ForgetsAllEdgesSoFarInOneRead) {
    const GpioBank bank;
    const auto input = GpioInput::open({bank.chip(), 2U}, false, GpioBias::as_is);
    ASSERT_TRUE(input) << input.error();
    // More edges than the kernel queues. Each one is seen before the next one comes.
    for (int edge = 0; edge < 41; ++edge) {
        bank.pull(2, edge % 2 == 0);
        EXPECT_EQ(events_within(**input, kLongMilliseconds), POLLIN);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(kShortMilliseconds));
    EXPECT_EQ((*input)->read(), std::optional(true));
    EXPECT_EQ(events_within(**input, kShortMilliseconds), 0);
}

TEST(GpioInput, IsReadWithoutHeap) {
    const GpioBank bank;
    const auto input = GpioInput::open({bank.chip(), 2U}, false, GpioBias::as_is);
    ASSERT_TRUE(input) << input.error();
    bank.pull(2, true);
    EXPECT_EQ(events_within(**input, kLongMilliseconds), POLLIN);
    const HeapTrap heap;
    const auto after_an_edge = (*input)->read();
    const auto without_one = (*input)->read();
    EXPECT_EQ(heap.allocations(), 0U);
    EXPECT_EQ(after_an_edge, std::optional(true));
    EXPECT_EQ(without_one, std::optional(true));
}

TEST(GpioInput, HoldsAFloatingLineUpOrDown) {
    const GpioBank bank;
    {
        const auto input = GpioInput::open({bank.chip(), 2U}, false, GpioBias::pull_up);
        ASSERT_TRUE(input) << input.error();
        EXPECT_EQ((*input)->read(), std::optional(true));
    }
    bank.pull(2, true);
    const auto input = GpioInput::open({bank.chip(), 2U}, false, GpioBias::pull_down);
    ASSERT_TRUE(input) << input.error();
    EXPECT_EQ((*input)->read(), std::optional(false));
}

TEST(GpioInput, LeavesAFloatingLineIfSoAsked) {
    const GpioBank bank;
    bank.pull(2, true);
    for (const GpioBias bias : {GpioBias::as_is, GpioBias::none}) {
        const auto input = GpioInput::open({bank.chip(), 2U}, false, bias);
        ASSERT_TRUE(input) << input.error();
        EXPECT_EQ((*input)->read(), std::optional(true));
    }
}

TEST(GpioInput, SaysThatItsChipIsGone) {
    GpioBank bank;
    const auto input = GpioInput::open({bank.chip(), 2U}, false, GpioBias::as_is);
    ASSERT_TRUE(input) << input.error();
    bank.remove();
    EXPECT_NE(events_within(**input, kLongMilliseconds), 0);
    EXPECT_EQ((*input)->read(), std::nullopt);
    EXPECT_EQ((*input)->read(), std::nullopt);
}

}  // namespace
}  // namespace tribus::test::gpio_input_test
