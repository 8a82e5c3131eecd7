#include <linux/can.h>
#include <linux/can/error.h>

#include <cerrno>
#include <chrono>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/loopback/program.h"

/// Checks that the laboratory's buses behave as the other tests expect.
namespace tribus::test::can_fixtures_test {
namespace {

constexpr std::chrono::milliseconds kSoon{200};

TEST(LabVirtualBus, CarriesClassicAndFdFrames) {
    const VirtualBus bus;
    RawCan sender(bus.name());
    RawCan receiver(bus.name());
    const CanFrame classic = make_frame(0x123, {1, 2, 3, 4, 5, 6, 7, 8});
    CanFrame fd = make_frame(0x12345678, std::vector<std::uint8_t>(64, 0xA5), true);
    fd.bit_rate_switch = true;
    // One frame at a time: frames from two processors may overtake each other.
    ASSERT_EQ(sender.send(classic), 0);
    const auto first = receiver.receive();
    ASSERT_EQ(sender.send(fd), 0);
    const auto second = receiver.receive();
    ASSERT_TRUE(first && second);
    EXPECT_EQ(first->frame, classic);
    EXPECT_EQ(second->frame, fd);
    EXPECT_TRUE(first->local);
    EXPECT_GT(first->kernel_time.count(), 0);
}

TEST(LabVirtualBus, ReaderLearnsThatItIsDownOrGone) {
    VirtualBus bus;
    RawCan reader(bus.name());
    const unsigned index = interface_index(bus.name());
    bus.down();
    reader.receive();
    EXPECT_EQ(reader.read_error(), ENETDOWN);
    EXPECT_EQ(reader.send(make_frame(1, {})), ENETDOWN);
    bus.remove();
    EXPECT_EQ(reader.send(make_frame(1, {})), ENXIO);
    bus.create();
    EXPECT_NE(interface_index(bus.name()), index);
    EXPECT_EQ(RawCan(bus.name()).send(make_frame(1, {})), 0);
}

TEST(LabVirtualBus, CarriesInjectedErrorFrames) {
    const VirtualBus bus;
    RawCan injector(bus.name());
    RawCan watcher(bus.name(), {.errors = CAN_ERR_MASK, .data_frames = false});
    ASSERT_EQ(injector.send_error(CAN_ERR_BUSOFF), 0);
    const auto sight = watcher.receive();
    ASSERT_TRUE(sight);
    EXPECT_TRUE(sight->error);
    EXPECT_EQ(sight->frame.id, static_cast<std::uint32_t>(CAN_ERR_BUSOFF));
}

TEST(LabPacedBus, TakesAsLongAsItsBitRateSays) {
    const PacedBus bus(125'000);
    RawCan sender(bus.near());
    RawCan receiver(bus.far());
    constexpr int kFrames = 100;
    const auto start = std::chrono::steady_clock::now();
    int sent = 0;
    EXPECT_TRUE(eventually([&] {
        while (sent < kFrames && sender.send(make_frame(0x100, {1, 2, 3, 4, 5, 6, 7, 8})) == 0) {
            ++sent;
        }
        return sent == kFrames;
    }));
    std::chrono::steady_clock::time_point latest{};
    for (int number = 0; number < kFrames; ++number) {
        const auto sight = receiver.receive();
        ASSERT_TRUE(sight) << number;
        latest = sight->seen;
    }
    // 128 bits a frame take 1.024 ms. The first frame is sent at once.
    EXPECT_GT(latest - start, std::chrono::microseconds(1024 * (kFrames - 2)));
}

TEST(LabPacedBus, QueuesTenFramesWhileItIsStalled) {
    const PacedBus bus(125'000);
    RawCan sender(bus.near());
    RawCan receiver(bus.far());
    bus.stall();
    int taken = 0;
    int error = 0;
    while (taken < 100 && (error = sender.send(make_frame(0x100, {}))) == 0) {
        ++taken;
    }
    EXPECT_EQ(error, ENOBUFS);
    EXPECT_GE(taken, 10);
    EXPECT_LE(taken, 12);
    bus.flow();
    for (int number = 0; number < taken; ++number) {
        EXPECT_TRUE(receiver.receive()) << number;
    }
}

TEST(LabPacedBus, CarriesFdFrames) {
    const PacedBus bus(500'000, PacedBus::Kind::fd);
    RawCan sender(bus.near());
    RawCan receiver(bus.far());
    const CanFrame frame = make_frame(0x100, std::vector<std::uint8_t>(64, 1), true);
    ASSERT_EQ(sender.send(frame), 0);
    const auto sight = receiver.receive();
    ASSERT_TRUE(sight);
    EXPECT_EQ(sight->frame, frame);
    EXPECT_FALSE(sight->local);
}

TEST(LabSlcan, SendsAndReceivesFrames) {
    SlcanAdapter adapter;
    RawCan socket(adapter.name());
    ASSERT_EQ(socket.send(make_frame(0x123, {0xAA, 0xBB})), 0);
    EXPECT_TRUE(eventually([&] { return adapter.heard().back() == "t1232AABB"; }));
    adapter.frame("t4561CC");
    const auto sight = socket.receive();
    ASSERT_TRUE(sight);
    EXPECT_EQ(sight->frame, make_frame(0x456, {0xCC}));
}

TEST(LabSlcan, GoesThroughTheStatesOfAController) {
    SlcanAdapter adapter;
    RawCan watcher(adapter.name(), {.errors = CAN_ERR_MASK, .data_frames = false});
    const auto next = [&] {
        const auto sight = watcher.receive();
        return sight ? sight->frame.id & ~static_cast<std::uint32_t>(CAN_ERR_CNT) : 0U;
    };
    const auto state = [&] { return shell("ip -details link show dev " + adapter.name()); };
    adapter.missing_acknowledge();
    EXPECT_NE(next() & CAN_ERR_ACK, 0U);
    adapter.error_warning();
    EXPECT_NE(next() & CAN_ERR_CRTL, 0U);
    EXPECT_NE(state().find("ERROR-WARNING"), std::string::npos);
    adapter.error_passive();
    EXPECT_NE(next() & CAN_ERR_CRTL, 0U);
    adapter.bus_off();
    EXPECT_NE(next() & CAN_ERR_BUSOFF, 0U);
    EXPECT_NE(state().find("BUS-OFF"), std::string::npos);
    set_link_down(adapter.name());
    set_link_up(adapter.name());
    EXPECT_NE(state().find("ERROR-ACTIVE"), std::string::npos) << state();
}

TEST(LabSlcan, FillsItsQueueWhileTheAdapterTakesNothing) {
    SlcanAdapter adapter;
    RawCan socket(adapter.name());
    adapter.block();
    int error = 0;
    EXPECT_TRUE(eventually([&] {
        error = socket.send(make_frame(0x100, {1, 2, 3, 4, 5, 6, 7, 8}));
        return error != 0;
    }));
    EXPECT_EQ(error, ENOBUFS);
    adapter.unblock();
    EXPECT_TRUE(eventually([&] { return socket.send(make_frame(0x7FF, {})) == 0; }));
    EXPECT_TRUE(eventually([&] { return adapter.heard().back() == "t7FF0"; }));
}

TEST(LabSlcan, CanBeUnpluggedAndPluggedAgain) {
    SlcanAdapter adapter;
    RawCan before(adapter.name());
    adapter.unplug();
    EXPECT_EQ(before.send(make_frame(1, {})), ENXIO);
    EXPECT_FALSE(before.receive(kSoon));
    adapter.plug();
    EXPECT_EQ(RawCan(adapter.name()).send(make_frame(1, {})), 0);
}

}  // namespace
}  // namespace tribus::test::can_fixtures_test
