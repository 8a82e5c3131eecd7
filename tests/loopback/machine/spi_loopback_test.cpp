#include "transports/links/spi/spi_loopback.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <functional>

#include <gtest/gtest.h>

#include "tests/support/spi_port_stand_in.h"
#include "transports/codecs/sbus/sbus.h"

/// What comes back by a wire between the data lines of an SPI port, with a stand-in for spidev.
namespace tribus::test::spi_loopback_test {
namespace {

constexpr const char* kDevice = "/dev/spidev9.7";

/// A port of nine clocks a byte. What comes in is what goes out, as `wire` changes it.
class SpiPort : public SpiPortStandIn {
  public:
    SpiPort() : SpiPortStandIn(kDevice) { clocks_a_byte = 9; }

    Answer control(unsigned long request, void* argument) override {
        return request == SPI_IOC_MESSAGE(1)
                   ? exchange(*static_cast<const spi_ioc_transfer*>(argument))
                   : SpiPortStandIn::control(request, argument);
    }
    Answer write(std::span<const std::uint8_t> bytes) override {
        pass(bytes.size());
        return static_cast<long>(bytes.size());
    }

    static Instant now() { return Instant(Duration(clock_ns)); }
    static inline std::atomic<std::int64_t> clock_ns = 0;

    std::function<std::uint8_t(std::uint8_t)> wire = [](std::uint8_t level) { return level; };
    /// From this transfer on the clock is slower by 3 %.
    int slower_from = 1'000'000;
    int refuses = 0;
    int exchanges = 0;

  private:
    Answer exchange(const spi_ioc_transfer& transfer) {
        if (refuses != 0) {
            return -refuses;
        }
        ++exchanges;
        const auto* sent = reinterpret_cast<const std::uint8_t*>(transfer.tx_buf);
        auto* received = reinterpret_cast<std::uint8_t*>(transfer.rx_buf);
        std::transform(sent, sent + transfer.len, received, wire);
        pass(transfer.len);
        return static_cast<long>(transfer.len);
    }
    void pass(std::size_t bytes) {
        slowness = exchanges >= slower_from ? 1.03 : 1;
        clock_ns += kCallNs + bytes_ns(bytes);
    }
};

SpiLoopback tried() {
    const auto found = try_spi_loopback(kDevice, kSbusProtocol.line, 100, SpiPort::now);
    EXPECT_TRUE(found.has_value()) << (found ? "" : found.error());
    return found.value_or(SpiLoopback{});
}

TEST(SpiLoopback, HasEachFrameThatComesBackByAWire) {
    const SpiPort port;
    const SpiLoopback found = tried();
    EXPECT_EQ(found.sent, 100);
    EXPECT_EQ(found.right, 100);
    EXPECT_EQ(found.silent, 0);
    // Nine clocks a byte of 10 us.
    EXPECT_NEAR(found.hz, 900'000, 4'500);
    EXPECT_NEAR(static_cast<double>(found.byte_before.count()), 10'000, 50);
    EXPECT_EQ(found.byte_after, found.byte_before);
}

TEST(SpiLoopback, HearsNothingWithoutAWire) {
    SpiPort port;
    port.wire = [](std::uint8_t) { return std::uint8_t{0}; };
    EXPECT_EQ(tried().silent, 100);
}

TEST(SpiLoopback, CountsFramesThatComeBackWrong) {
    SpiPort port;
    int exchange = 0;
    port.wire = [&, last = 0, byte = 0](std::uint8_t level) mutable {
        byte = port.exchanges == std::exchange(last, port.exchanges) ? byte + 1 : 0;
        exchange = port.exchanges;
        // In each tenth frame a bit in the middle is another one.
        return static_cast<std::uint8_t>(exchange % 10 == 0 && byte == 150 ? ~level : level);
    };
    const SpiLoopback found = tried();
    EXPECT_EQ(found.right, 90);
    EXPECT_EQ(found.silent, 0);
}

TEST(SpiLoopback, MeasuresThatTheClockChanged) {
    SpiPort port;
    port.slower_from = 50;
    const SpiLoopback found = tried();
    EXPECT_NEAR(static_cast<double>(found.byte_after.count()) /
                    static_cast<double>(found.byte_before.count()),
                1.03, 0.001);
}

TEST(SpiLoopback, SaysThatThePortDoesNotReceive) {
    SpiPort port;
    port.refuses = EINVAL;
    const auto found = try_spi_loopback(kDevice, kSbusProtocol.line, 100, SpiPort::now);
    ASSERT_FALSE(found.has_value());
    EXPECT_EQ(found.error(),
              std::string(kDevice) + ": it sends but does not receive: Invalid argument");
}

}  // namespace
}  // namespace tribus::test::spi_loopback_test
