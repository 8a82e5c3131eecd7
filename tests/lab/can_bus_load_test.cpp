#include <csignal>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/loopback/loopback.h"
#include "tests/support/can_bits.h"
#include "tests/support/streams.h"
#include "transports/codecs/dronecan/rc.h"

/// Compares with canbusload of can-utils, which also counts stuff bits, but only of classic frames.
namespace tribus::test::can_bus_load_test {
namespace {

struct Load {
    std::size_t frames = 0;
    std::size_t bits = 0;

    bool operator==(const Load&) const = default;
};

/// Returns the sum of its lines, one a second: " vcan0@1000000     3     408    192   0%".
Load shown(const std::string& output) {
    Load sum;
    std::istringstream words(output);
    for (std::string word; words >> word;) {
        Load line;
        if (word.starts_with("vcan0@") && words >> line.frames >> line.bits) {
            sum.frames += line.frames;
            sum.bits += line.bits;
        }
    }
    return sum;
}

class CanBusLoad : public Loopback {
  protected:
    VirtualBus bus_;
    Program canbusload_{folder(), {"-e", "vcan0@1000000"}, {.executable = "/usr/bin/canbusload"}};
};

TEST_F(CanBusLoad, IsThatOfTheBitsThatTheTestsCountInRcInputOf18Channels) {
    ASSERT_TRUE(eventually([] {
        return read_file("/proc/net/can/rcvlist_all").find(" raw") != std::string::npos;
    })) << canbusload_.errors();
    RawCan bus("vcan0");
    dronecan::RcEncoder encoder({.node = 42});
    Random random(1);
    Load sent;
    for (std::uint32_t transfer = 1; transfer <= 40; ++transfer) {
        ChannelFrame snapshot;
        snapshot.frame_lost = false;
        snapshot.failsafe = false;
        snapshot.sequence = transfer;
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            snapshot.set(channel, Pulse::from_microseconds(
                                      static_cast<std::int32_t>(1000 + random.below(1001))));
        }
        std::array<CanFrame, kMostSnapshotFrames> frames;
        const std::size_t count = encoder.write(snapshot, frames, Instant{});
        for (const CanFrame& frame : std::span(frames).first(count)) {
            ASSERT_EQ(bus.send(frame), 0);
            sent.bits += bits_on_bus(frame).nominal;
            ++sent.frames;
        }
    }
    ASSERT_EQ(sent.frames, 200U);
    EXPECT_TRUE(eventually([&] { return shown(canbusload_.output()).frames >= sent.frames; }))
        << canbusload_.output();
    const Load counted = shown(canbusload_.output());
    EXPECT_EQ(counted.frames, sent.frames);
    EXPECT_EQ(counted.bits, sent.bits);
    canbusload_.signal(SIGTERM);
    canbusload_.end();
}

}  // namespace
}  // namespace tribus::test::can_bus_load_test
