#include "transports/links/spi/spi_clock_watch.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <random>

#include <gtest/gtest.h>

/// Whether the clock of an SPI port has changed, seen by the duration of transfers.
namespace tribus::test::spi_clock_watch_test {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kFrameBytes = 304;

/// How long its transfers take.
struct Port {
    double byte_us = 10;
    double call_us = 40;
    double held_up_us = 0;  ///< at most, at random
    std::mt19937 random{1};

    Duration transfer(std::size_t bytes) {
        std::uniform_real_distribution<double> held(0, held_up_us);
        const double us = call_us + static_cast<double>(bytes) * byte_us + held(random);
        return Duration(static_cast<std::int64_t>(us * 1000));
    }
};

/// Frames, and the zeros that decide whenever it suspects something. Returns whether they decided
/// that the clock has changed.
bool changes_within(SpiClockWatch& watch, Port& port, int frames) {
    for (int i = 0; i < frames; ++i) {
        watch.transferred(kFrameBytes, port.transfer(kFrameBytes));
        const std::size_t zeros = watch.wanted_zeros();
        if (zeros > 0 && watch.compared(port.transfer(zeros))) {
            return true;
        }
    }
    return false;
}

TEST(SpiClockWatch, SuspectsNothingOfAClockThatStays) {
    SpiClockWatch watch(10us);
    Port port;
    EXPECT_FALSE(changes_within(watch, port, 100));
    for (int i = 0; i < 10'000; ++i) {
        watch.transferred(kFrameBytes, port.transfer(kFrameBytes));
        ASSERT_EQ(watch.wanted_zeros(), 0U);
    }
}

/// Any transfer may take up to 100 us more.
TEST(SpiClockWatch, SuspectsNothingOnABusyMachine) {
    SpiClockWatch watch(10us);
    Port port;
    port.held_up_us = 100;
    EXPECT_FALSE(changes_within(watch, port, 100));
    for (int i = 0; i < 10'000; ++i) {
        watch.transferred(kFrameBytes, port.transfer(kFrameBytes));
        ASSERT_EQ(watch.wanted_zeros(), 0U) << i;
    }
}

class SpiClockWatchOf : public testing::TestWithParam<double> {
  protected:
    double change() const { return GetParam(); }
};

TEST_P(SpiClockWatchOf, AChangeIsSureWithin256Frames) {
    for (const double held_up_us : {0.0, 100.0}) {
        for (int before = 0; before < 200; before += 7) {
            SpiClockWatch watch(10us);
            Port port;
            port.held_up_us = held_up_us;
            EXPECT_FALSE(changes_within(watch, port, before));
            port.byte_us /= change();
            EXPECT_TRUE(changes_within(watch, port, 256)) << before << " frames before";
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Clocks, SpiClockWatchOf,
                         testing::Values(0.4, 0.5, 0.9, 0.95, 0.98, 1.025, 1.05, 1.1, 2.0, 2.5));

TEST(SpiClockWatch, DoesNotTakeAMachineThatBecameBusyForAClock) {
    SpiClockWatch watch(10us);
    Port port;
    EXPECT_FALSE(changes_within(watch, port, 100));
    port.call_us = 400;
    EXPECT_FALSE(changes_within(watch, port, 1000));
    port.call_us = 40;
    EXPECT_FALSE(changes_within(watch, port, 1000));
}

TEST(SpiClockWatch, BearsAChangeOfOnePercent) {
    SpiClockWatch watch(10us);
    Port port;
    EXPECT_FALSE(changes_within(watch, port, 100));
    port.byte_us /= 1.01;
    EXPECT_FALSE(changes_within(watch, port, 1000));
}

}  // namespace
}  // namespace tribus::test::spi_clock_watch_test
