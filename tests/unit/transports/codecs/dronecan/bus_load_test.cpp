#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/channel_frame.h"
#include "core/pulse.h"
#include "tests/support/can_bits.h"
#include "tests/support/dronecan_frames.h"
#include "tests/support/streams.h"
#include "transports/codecs/dronecan/dronecan.h"
#include "transports/codecs/dronecan/rc.h"

/// Bus load of RCInput, compared with the table of docs/protocols/can.md, "Bus load".
namespace tribus::dronecan::bus_load_test {
namespace {

using namespace test;
using std::chrono::milliseconds;

class Sender {
  public:
    explicit Sender(bool fd) : encoder_({.node = 42, .fd = fd}) {}

    /// Returns the frames of one transfer, with sticks over their whole range.
    std::vector<CanFrame> send(std::size_t channels) {
        ChannelFrame snapshot;
        snapshot.frame_lost = false;
        snapshot.failsafe = false;
        snapshot.sequence = ++sequence_;
        for (std::size_t channel = 0; channel < channels; ++channel) {
            snapshot.set(channel, Pulse::from_microseconds(
                                      static_cast<std::int32_t>(1000 + random_.below(1001))));
        }
        std::array<CanFrame, kMostSnapshotFrames> frames;
        const std::size_t count = encoder_.write(snapshot, frames, kStart);
        return {frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count)};
    }

  private:
    RcEncoder encoder_;
    Random random_{1};
    std::uint32_t sequence_ = 0;
};

constexpr bool kClassic = false;
constexpr bool kFd = true;

/// Returns the load of a bus with one such transfer each `period`, in tenths of a percent.
long per_mille(std::span<const CanFrame> transfer, milliseconds period, std::size_t nominal_rate,
               std::size_t data_rate = 1'000'000) {
    const auto time = time_on_bus(most_bits_on_bus(transfer), nominal_rate, data_rate);
    return std::lround(1000 * std::chrono::duration<double>(time) / period);
}

TEST(BusLoadOfRcInput, EighteenChannelsAreFiveClassicFramesOf780BitsAtMost) {
    const auto transfer = Sender(kClassic).send(18);
    EXPECT_EQ(transfer.size(), 5U);
    EXPECT_EQ(most_bits_on_bus(transfer), BusBits{.nominal = 780});
}

TEST(BusLoadOfRcInput, SixteenChannelsAreFiveClassicFramesOf750BitsAtMost) {
    const auto transfer = Sender(kClassic).send(16);
    EXPECT_EQ(transfer.size(), 5U);
    EXPECT_EQ(most_bits_on_bus(transfer), BusBits{.nominal = 750});
}

TEST(BusLoadOfRcInput, RandomDataTakeAsManyBitsOnAverageAsTheTableSays) {
    const auto average = [](std::size_t channels) {
        Sender sender(kClassic);
        constexpr std::size_t kTransfers = 1000;
        std::size_t sum = 0;
        for (std::size_t i = 0; i < kTransfers; ++i) {
            sum += bits_on_bus(sender.send(channels)).nominal;
        }
        return static_cast<double>(sum) / kTransfers;
    };
    EXPECT_NEAR(average(18), 658, 1);
    EXPECT_NEAR(average(16), 634, 1);
}

TEST(BusLoadOfRcInput, NoContentsTakeMoreBitsThanTheMost) {
    for (const bool fd : {kClassic, kFd}) {
        Sender sender(fd);
        for (int i = 0; i < 1000; ++i) {
            const auto transfer = sender.send(18);
            const BusBits bits = bits_on_bus(transfer);
            const BusBits most = most_bits_on_bus(transfer);
            ASSERT_TRUE(bits.nominal <= most.nominal && bits.data <= most.data);
        }
    }
}

TEST(BusLoadOfRcInput, EighteenChannelsLoadAClassicBusAsTheTableSays) {
    const auto transfer = Sender(kClassic).send(18);
    EXPECT_EQ(per_mille(transfer, milliseconds(7), 250'000), 446);
    EXPECT_EQ(per_mille(transfer, milliseconds(7), 500'000), 223);
    EXPECT_EQ(per_mille(transfer, milliseconds(7), 1'000'000), 111);
    EXPECT_EQ(per_mille(transfer, milliseconds(20), 250'000), 156);
    EXPECT_EQ(per_mille(transfer, milliseconds(20), 500'000), 78);
    EXPECT_EQ(per_mille(transfer, milliseconds(20), 1'000'000), 39);
}

/// 500 frames and 78,000 bits a second: between the two periods of the table.
TEST(BusLoadOfRcInput, EighteenChannelsAtTheDefaultPeriodLoadABusOf1MbitBy8Percent) {
    const auto transfer = Sender(kClassic).send(18);
    const auto period = std::chrono::duration_cast<milliseconds>(kDroneCanProtocol.default_period);
    EXPECT_EQ(per_mille(transfer, period, 1'000'000), 78);
    EXPECT_EQ(per_mille(transfer, period, 250'000), 312);
}

/// 374 us at 500 kbit/s and 2 Mbit/s, 187 us at twice these rates.
TEST(BusLoadOfRcInput, EighteenChannelsAreOneFdFrameOf48BytesThatLoadsABusAsTheTableSays) {
    const auto transfer = Sender(kFd).send(18);
    ASSERT_EQ(transfer.size(), 1U);
    EXPECT_EQ(transfer[0].length, 48);
    EXPECT_EQ(most_bits_on_bus(transfer), (BusBits{.nominal = 57, .data = 519}));
    EXPECT_EQ(per_mille(transfer, milliseconds(7), 500'000, 2'000'000), 53);
    EXPECT_EQ(per_mille(transfer, milliseconds(20), 500'000, 2'000'000), 19);
    EXPECT_EQ(per_mille(transfer, milliseconds(7), 1'000'000, 4'000'000), 27);
    EXPECT_EQ(per_mille(transfer, milliseconds(20), 1'000'000, 4'000'000), 9);
}

}  // namespace
}  // namespace tribus::dronecan::bus_load_test
