#include "transports/links/spi/spi_clock.h"

#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <gtest/gtest.h>

#include "tests/support/spi_controller.h"

namespace tribus::spi_clock_test {
namespace {

using namespace std::chrono_literals;
using test::SpiController;

constexpr Duration kBit = 10us;

tl::expected<std::uint32_t, std::string> rate_of(SpiController& controller) {
    return find_spi_rate(kBit, [&](std::uint32_t hz, std::size_t bytes) {
        return controller.transfer_time(hz, bytes);
    });
}

double byte_us(const SpiController& controller, std::uint32_t hz) {
    return controller.clocks_a_byte * 1e6 / controller.clock_hz(hz);
}

TEST(SpiClock, FindsTheRateWhateverTheClocksOfAByte) {
    for (const double core_hz : {250e6, 400e6, 500e6, 48e6, 24e6, 102e6}) {
        for (const double clocks : {8.0, 8.25, 8.5, 9.0}) {
            for (const double held_up_us : {0.0, 100.0}) {
                SpiController controller{.core_hz = core_hz,
                                         .even_divider = core_hz > 200e6,
                                         .clocks_a_byte = clocks,
                                         .held_up_us = held_up_us};
                const auto rate = rate_of(controller);
                // A byte as a divider gives it, and what of the measurement is noise.
                if (rate) {
                    EXPECT_NEAR(byte_us(controller, *rate), 10, held_up_us > 0 ? 0.11 : 0.051)
                        << core_hz << ' ' << clocks;
                } else {
                    EXPECT_LT(core_hz, 50e6) << rate.error();
                }
            }
        }
    }
}

TEST(SpiClock, SaysWithFiguresThatNoRateFits) {
    // A clock of 12 MHz by even numbers: 750 kHz and 857 kHz are neighbours.
    SpiController controller{.core_hz = 12e6};
    const auto rate = rate_of(controller);
    ASSERT_FALSE(rate);
    EXPECT_TRUE(
        rate.error().starts_with("no rate fits: a byte must take 10.00 us, within 0.5 %, "
                                 "and takes "))
        << rate.error();
    EXPECT_NE(rate.error().find("10.67 us at 800000 Hz"), std::string::npos) << rate.error();
}

TEST(SpiClock, SaysThatAPortIsNoPort) {
    const auto at_once = find_spi_rate(kBit, [](std::uint32_t, std::size_t) { return 20us; });
    ASSERT_FALSE(at_once);
    EXPECT_EQ(at_once.error(),
              "a byte at 800000 Hz takes 0.00 us, so it is no SPI port that sends by a clock");
    const auto refused = find_spi_rate(
        kBit, [](std::uint32_t, std::size_t) -> std::optional<Duration> { return {}; });
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error(), "it refuses a transfer at 800000 Hz");
}

}  // namespace
}  // namespace tribus::spi_clock_test
