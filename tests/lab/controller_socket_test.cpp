#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/can_link_driver.h"
#include "tests/lab/guest.h"
#include "transports/links/can/can_socket.h"

/// The SocketCAN link on controllers.
namespace tribus::test::controller_socket_test {
namespace {

const std::vector<std::uint32_t> kSnapshotIds{0x300, 0x301, 0x302, 0x303};

TEST(LabCanSocket, AControllerGetsTheFirstFrameAloneThenWholeSnapshotsEachWhenTheOneBeforeIsSent) {
    const ControllerPair pair;
    RawCan listener(pair.far());
    const auto link = open_link(pair.near());
    ASSERT_TRUE(link->interface().echo);
    LinkDriver driver(*link);
    EXPECT_EQ(driver.write(), WriteStatus::written);
    EXPECT_EQ(driver.counts().sent, 1U);
    EXPECT_EQ(driver.counts().confirmed, 0U);
    EXPECT_EQ(driver.write(), WriteStatus::busy);
    ASSERT_TRUE(driver.run_until([&] { return driver.counts().confirmed == kSnapshotFrames; }));
    EXPECT_EQ(driver.write(), WriteStatus::written);
    EXPECT_EQ(driver.counts().sent, 2 * kSnapshotFrames);
    ASSERT_TRUE(driver.run_until([&] { return driver.counts().confirmed == 2 * kSnapshotFrames; }));
    for (int number = 0; number < 2; ++number) {
        for (const std::uint32_t id : kSnapshotIds) {
            const auto sight = listener.receive();
            ASSERT_TRUE(sight);
            EXPECT_EQ(sight->frame.id, id);
        }
    }
}

// One frame a snapshot: the emulated bus has no rate, and two frames overrun the emulated receiver.
TEST(LabCanSocket, AControllerCarriesAStreamWithoutLoss) {
    const ControllerPair pair;
    RawCan listener(pair.far());
    const auto link = open_link(pair.near());
    LinkDriver driver(*link);
    const auto fates = driver.stream_for(1s, 1);
    EXPECT_EQ(std::ranges::count(fates, WriteStatus::written), std::ssize(fates));
    ASSERT_TRUE(driver.run_until([&] { return driver.counts().confirmed == fates.size(); }));
    Instant latest{};
    for (std::size_t number = 0; number < fates.size(); ++number) {
        const auto sight = listener.receive();
        ASSERT_TRUE(sight) << number;
        EXPECT_GT(offered_at(sight->frame), latest);
        latest = offered_at(sight->frame);
    }
    EXPECT_EQ(driver.counts().stalls, 0U);
}

TEST(LabCanSocketOpening, RefusesFdOnAControllerWithTheOptionThatChangesIt) {
    LinkUse settings = usual_settings();
    settings.fd = true;
    const ControllerPair pair;
    const auto link = CanSocket::open(pair.near(), settings);
    ASSERT_FALSE(link);
    EXPECT_NE(link.error().find("fd on"), std::string::npos) << link.error();
}

TEST(LabCanInterface, TellsWhatAControllerIsSetTo) {
    const ControllerPair pair(250'000, "restart-ms 200");
    const auto interface = query_can_interface(pair.near());
    ASSERT_TRUE(interface) << interface.error();
    EXPECT_EQ(interface->kind, "can");
    EXPECT_EQ(interface->bit_rate, 250'000U);
    EXPECT_EQ(interface->restart_ms, 200U);
    EXPECT_EQ(interface->state, CanControllerState::active);
    EXPECT_EQ(interface->mtu, 16U);
    EXPECT_TRUE(interface->up);
    EXPECT_TRUE(interface->lower_up);
    EXPECT_TRUE(advice(*interface, true, false).empty());
}

TEST(LabCanInterface, AControllerThatIsNotInBusOffCannotBeRestarted) {
    const ControllerPair pair;
    const auto answer = restart_can_interface(pair.near());
    ASSERT_FALSE(answer);
    EXPECT_NE(answer.error().find("not in bus-off"), std::string::npos) << answer.error();
}

TEST(LabCanFaults, AControllerThatGoesDownAndUpWorksAgain) {
    const ControllerPair pair;
    RawCan listener(pair.far());
    const auto link = open_link(pair.near());
    LinkDriver driver(*link);
    driver.stream_for(50ms);
    set_link_down(pair.near());
    ASSERT_TRUE(driver.run_until_state(CanBusState::down));
    driver.stream_for(100ms);
    listener.receive_all();
    const Instant back = now();
    set_link_up(pair.near());
    record(time_to_next_written(driver));
    ASSERT_TRUE(driver.run_until([&] { return driver.status().state == CanBusState::ready; }));
    driver.stream_for(100ms);
    const auto sights = listener.receive_all();
    EXPECT_GT(sights.size(), kSnapshotFrames);
    EXPECT_TRUE(std::ranges::none_of(
        sights, [&](const CanSight& sight) { return offered_at(sight.frame) < back; }));
}

TEST(LabCanFaults, AControllerThatIsUnpluggedIsLostAndCanBeOpenedAgain) {
    ControllerPair pair;
    auto link = open_link(pair.near());
    LinkDriver driver(*link);
    driver.stream_for(50ms);
    pair.unplug();
    EXPECT_TRUE(driver.run_until([&] { return driver.latest_read() == ReadStatus::lost; }));
    EXPECT_EQ(driver.write(), WriteStatus::lost);
    pair.plug();
    RawCan listener(pair.far());
    link = open_link(pair.near());
    LinkDriver again(*link);
    EXPECT_EQ(again.write(1), WriteStatus::written);
    EXPECT_TRUE(again.run_until([&] { return again.counts().confirmed == 1; }));
    EXPECT_TRUE(listener.receive());
}

}  // namespace
}  // namespace tribus::test::controller_socket_test
