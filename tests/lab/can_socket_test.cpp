#include "transports/links/can/can_socket.h"

#include <linux/can.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/can_link_driver.h"
#include "tests/lab/guest.h"

/// The SocketCAN link on buses without faults.
namespace tribus::test::can_socket_test {
namespace {

std::vector<std::uint32_t> ids(const std::vector<ReceivedCanFrame>& received) {
    std::vector<std::uint32_t> found;
    for (const ReceivedCanFrame& one : received) {
        found.push_back(one.frame.id);
    }
    return found;
}

const std::vector<std::uint32_t> kSnapshotIds{0x300, 0x301, 0x302, 0x303};

TEST(LabCanSocket, SendsAWholeSnapshotAtOnceWhereTheBusHasNoRate) {
    const VirtualBus bus;
    RawCan listener(bus.name());
    const auto link = open_link(bus.name());
    LinkDriver driver(*link);
    EXPECT_EQ(driver.write(), WriteStatus::written);
    EXPECT_EQ(driver.counts().confirmed, kSnapshotFrames);
    for (const std::uint32_t id : kSnapshotIds) {
        const auto sight = listener.receive();
        ASSERT_TRUE(sight);
        EXPECT_EQ(sight->frame.id, id);
    }
    driver.run_for(50ms);
    EXPECT_TRUE(driver.received().empty()) << "the link received its own frames";
    EXPECT_EQ(driver.status().state, CanBusState::ready);
}

TEST(LabCanSocket, OnAPacedBusOneSnapshotIsInTheQueueAtATime) {
    const PacedBus bus(125'000);
    RawCan listener(bus.far());
    const auto link = open_link(bus.near());
    LinkDriver driver(*link);
    constexpr std::size_t kSnapshots = 3;
    for (std::size_t lane = 0; lane < kSnapshots; ++lane) {
        driver.write(kSnapshotFrames, lane);
    }
    ASSERT_TRUE(driver.run_until([&] {
        EXPECT_LE(driver.counts().sent - driver.counts().confirmed, kSnapshotFrames);
        return driver.counts().confirmed == kSnapshots * kSnapshotFrames;
    }));
    EXPECT_EQ(listener.receive_all(kSnapshots * kSnapshotFrames).size(),
              kSnapshots * kSnapshotFrames);
}

TEST(LabCanSocket, ServesAllLanes) {
    const PacedBus bus(125'000);
    RawCan listener(bus.far());
    const auto link = open_link(bus.near());
    LinkDriver driver(*link);
    for (std::size_t lane = 0; lane < 3; ++lane) {
        EXPECT_EQ(driver.write(2, lane), WriteStatus::written);
    }
    ASSERT_TRUE(driver.run_until([&] { return driver.counts().confirmed == 6; }));
    EXPECT_EQ(listener.receive_all(6).size(), 6U);
}

TEST(LabCanSocket, WhatArrivesOnACrowdedBusIsNeverOld) {
    const PacedBus bus(125'000);
    RawCan listener(bus.far());
    RawCan crowd(bus.near());
    const auto link = open_link(bus.near());
    LinkDriver driver(*link);
    Duration oldest{};
    std::size_t arrived = 0;
    for (int turn = 0; turn < 200; ++turn) {
        while (crowd.send(make_frame(0x100, std::vector<std::uint8_t>(8))) == 0) {
        }
        if (turn % 2 == 0) {
            driver.write();
        }
        driver.run_for(3ms);
        for (const CanSight& sight : listener.receive_all()) {
            if (sight.frame.id >= kFirstSent) {
                ++arrived;
                const Instant seen(sight.seen.time_since_epoch());
                oldest = std::max(oldest, seen - offered_at(sight.frame));
            }
        }
    }
    EXPECT_GT(arrived, 10U);
    EXPECT_GT(driver.counts().queue_full, 0U);
    // At most 50 ms until the frame is queued, then ten frames of 1.024 ms before it in the queue,
    // and the test's own time.
    EXPECT_LT(oldest, 50ms + 10 * 1024us + 40ms);
    RecordProperty("oldest_us", static_cast<int>(oldest / 1us));
}

TEST(LabCanSocket, FiltersTellStandardExtendedAndRemoteFramesApart) {
    const VirtualBus bus;
    RawCan sender(bus.name());
    const auto link = open_link(
        bus.name(),
        {.wanted = {standard_id(0x123), {.id = 0x456, .extended = true}}, .sent = {}, .fd = false});
    LinkDriver driver(*link);
    CanFrame extended = make_frame(0x123, {1});
    extended.extended = true;
    CanFrame remote = make_frame(0x123, {});
    remote.remote = true;
    CanFrame wanted_extended = make_frame(0x456, {2});
    wanted_extended.extended = true;
    const std::vector<CanFrame> sent{extended, remote, make_frame(0x456, {3}), wanted_extended,
                                     make_frame(0x123, {4})};
    for (const CanFrame& frame : sent) {
        ASSERT_EQ(sender.send(frame), 0);
    }
    driver.run_for(100ms);
    EXPECT_EQ(ids(driver.received()), (std::vector<std::uint32_t>{0x456, 0x123}));
}

TEST(LabCanSocket, TellsOtherProgramsFromTheBus) {
    const PacedBus bus(500'000);
    RawCan program(bus.near());
    RawCan node(bus.far());
    const auto link = open_link(bus.near());
    LinkDriver driver(*link);
    ASSERT_EQ(program.send(make_frame(kFirstSent, {1})), 0);
    ASSERT_TRUE(driver.run_until([&] { return driver.received().size() == 1; }));
    EXPECT_EQ(driver.received()[0].sender, CanSender::local);
    ASSERT_EQ(node.send(make_frame(kFirstSent, {2})), 0);
    ASSERT_TRUE(driver.run_until([&] { return driver.received().size() == 2; }));
    EXPECT_EQ(driver.received()[1].sender, CanSender::bus);
}

TEST(LabCanSocket, KnowsWhenAFrameArrivedAlthoughItIsReadLate) {
    const VirtualBus bus;
    RawCan sender(bus.name());
    const auto link = open_link(bus.name());
    LinkDriver driver(*link);
    // The kernel begins to stamp frames only some time after the first socket has asked for stamps.
    driver.run_for(500ms);
    ASSERT_EQ(sender.send(make_frame(0x123, {})), 0);
    ASSERT_TRUE(driver.run_until([&] { return driver.received().size() == 1; }));
    const Instant before = now();
    ASSERT_EQ(sender.send(make_frame(0x123, {})), 0);
    const Instant after = now();
    ::poll(nullptr, 0, 400);
    ASSERT_TRUE(driver.run_until([&] { return driver.received().size() == 2; }));
    // The two clocks are read one after the other.
    EXPECT_GT(driver.received()[1].at, before - 5ms);
    EXPECT_LT(driver.received()[1].at, after + 5ms);
    EXPECT_EQ(driver.counts().implausible_times, 0U);
}

TEST(LabCanSocket, CarriesFdFramesBothWays) {
    const VirtualBus bus;
    RawCan node(bus.name());
    LinkUse settings = usual_settings();
    settings.fd = true;
    const auto link = open_link(bus.name(), settings);
    LinkDriver driver(*link);
    CanFrame frame = make_frame(kFirstSent, std::vector<std::uint8_t>(64, 0xA5), true);
    frame.bit_rate_switch = true;
    EXPECT_EQ(driver.write(std::vector<CanFrame>{frame}), WriteStatus::written);
    const auto sight = node.receive();
    ASSERT_TRUE(sight);
    EXPECT_EQ(sight->frame, frame);
    frame.id = 0x123;
    ASSERT_EQ(node.send(frame), 0);
    ASSERT_TRUE(driver.run_until([&] { return !driver.received().empty(); }));
    EXPECT_EQ(driver.received()[0].frame, frame);
}

TEST(LabCanSocket, WhatASocketHasNoRoomForIsCounted) {
    const VirtualBus bus;
    RawCan sender(bus.name());
    const auto link = open_link(bus.name());
    LinkDriver driver(*link);
    // The link has read once, so it believes any age since then, however slow this machine is.
    ASSERT_EQ(sender.send(make_frame(0x123, {})), 0);
    ASSERT_TRUE(driver.run_until([&] { return driver.received().size() == 1; }));
    constexpr std::uint64_t kFlood = 5000;
    for (std::uint64_t sent = 0; sent < kFlood; ++sent) {
        ASSERT_EQ(sender.send(make_frame(0x123, {})), 0);
    }
    driver.run_for(100ms);
    ASSERT_EQ(sender.send(make_frame(0x123, {})), 0);
    driver.run_for(100ms);
    EXPECT_GT(driver.counts().receive_overflows, 0U);
    EXPECT_EQ(driver.counts().received + driver.counts().receive_overflows, kFlood + 2);
    // A bus full of the shortest frames for 50 ms.
    EXPECT_GT(driver.counts().received, 500U);
}

std::string open_problem(const std::string& interface, const LinkUse& settings) {
    const auto link = CanSocket::open(interface, settings);
    return link ? "none" : link.error();
}

TEST(LabCanSocketOpening, NamesTheInterfacesThatThereAre) {
    const VirtualBus bus;
    const std::string problem = open_problem("vcan7", usual_settings());
    EXPECT_NE(problem.find("vcan7: there is no such network interface"), std::string::npos);
    EXPECT_NE(problem.find(bus.name()), std::string::npos) << problem;
}

TEST(LabCanSocketOpening, RefusesFdWhereTheInterfaceHasNone) {
    LinkUse settings = usual_settings();
    settings.fd = true;
    const PacedBus bus(125'000);
    const std::string problem = open_problem(bus.near(), settings);
    EXPECT_NE(problem.find("mtu 72"), std::string::npos) << problem;
}

TEST(LabCanSocketOpening, TakesAsManyFiltersAsTheKernelAndNoMore) {
    const VirtualBus bus;
    LinkUse settings;
    for (std::uint32_t id = 0; id < 512; ++id) {
        settings.wanted.push_back(standard_id(id));
    }
    EXPECT_EQ(open_problem(bus.name(), settings), "none");
    settings.sent.push_back(standard_id(512));
    EXPECT_NE(open_problem(bus.name(), settings).find("513 different ids"), std::string::npos);
}

TEST(LabCanSocketOpening, TakesAnInterfaceThatIsDownAndUsesItWhenItIsUp) {
    const VirtualBus bus;
    bus.down();
    const auto link = open_link(bus.name());
    ASSERT_TRUE(link);
    LinkDriver driver(*link);
    EXPECT_EQ(driver.status().state, CanBusState::down);
    EXPECT_EQ(driver.write(), WriteStatus::unavailable);
    bus.up();
    EXPECT_TRUE(driver.run_until_state(CanBusState::ready));
    EXPECT_EQ(driver.write(), WriteStatus::written);
}

TEST(LabCanInterface, AVirtualBusHasNoEcho) {
    const VirtualBus bus;
    const auto interface = query_can_interface(bus.name());
    ASSERT_TRUE(interface) << interface.error();
    EXPECT_EQ(interface->kind, "vcan");
    EXPECT_FALSE(interface->echo);
    EXPECT_EQ(interface->mtu, 72U);
}

}  // namespace
}  // namespace tribus::test::can_socket_test
