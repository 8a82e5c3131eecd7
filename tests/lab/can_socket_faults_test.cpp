#include <linux/can/error.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipelines/realtime/clock.h"
#include "tests/lab/can_link_driver.h"
#include "tests/lab/guest.h"
#include "transports/links/can/can_socket.h"

/// The SocketCAN link during and after failures of its bus.
namespace tribus::test::can_socket_faults_test {
namespace {

std::ptrdiff_t count(const std::vector<WriteStatus>& fates, WriteStatus fate) {
    return std::ranges::count(fates, fate);
}

TEST(LabCanFaults, AfterAnOutageOfTheBusOneOldSnapshotArrivesAtMost) {
    const PacedBus bus(125'000);
    RawCan listener(bus.far());
    const auto link = open_link(bus.near());
    LinkDriver driver(*link);
    driver.stream_for(100ms);
    bus.stall();
    const auto fates = driver.stream_for(5s);
    EXPECT_EQ(driver.status().state, CanBusState::stalled);
    EXPECT_GE(driver.counts().stalls, 1U);
    EXPECT_GT(count(fates, WriteStatus::unavailable), 100);
    EXPECT_EQ(driver.counts().queue_full, 0U);
    listener.receive_all();

    const Instant back = now();
    bus.flow();
    record(time_to_next_written(driver));
    driver.stream_for(200ms);
    const auto sights = listener.receive_all();
    EXPECT_GT(sights.size(), 20U);
    const auto old = std::ranges::count_if(
        sights, [&](const CanSight& sight) { return offered_at(sight.frame) < back; });
    EXPECT_LE(old, std::ptrdiff_t{kSnapshotFrames});
    EXPECT_EQ(driver.status().state, CanBusState::ready);
}

TEST(LabCanFaults, AnInterfaceThatGoesDownAndUpWorksAgainWithTheSameSocket) {
    const VirtualBus bus;
    RawCan listener(bus.name());
    const auto link = open_link(bus.name());
    LinkDriver driver(*link);
    driver.stream_for(50ms);
    bus.down();
    ASSERT_TRUE(driver.run_until_state(CanBusState::down));
    EXPECT_EQ(driver.counts().downs, 1U);
    EXPECT_EQ(driver.write(), WriteStatus::unavailable);
    listener.receive_all();  // its own message that the bus is down
    listener.receive_all();
    bus.up();
    record(time_to_next_written(driver));
    driver.run_for(50ms);
    for (std::size_t number = 0; number < kSnapshotFrames; ++number) {
        EXPECT_TRUE(listener.receive()) << number;
    }
    ASSERT_EQ(listener.send(make_frame(0x123, {})), 0);
    EXPECT_TRUE(driver.run_until([&] { return !driver.received().empty(); }));
}

TEST(LabCanFaults, AReaderAloneNoticesDownAndUp) {
    const VirtualBus bus;
    const auto link = open_link(bus.name(), {.wanted = {standard_id(0x123)}, .sent = {}});
    LinkDriver driver(*link);
    bus.down();
    ASSERT_TRUE(driver.run_until_state(CanBusState::down));
    bus.up();
    EXPECT_TRUE(driver.run_until_state(CanBusState::ready));
}

TEST(LabCanFaults, WaitingOnAnInterfaceThatIsDownDoesNotSpin) {
    const VirtualBus bus;
    const auto link = open_link(bus.name());
    LinkDriver driver(*link);
    bus.down();
    ASSERT_TRUE(driver.run_until_state(CanBusState::down));
    const int before = driver.wakes();
    driver.run_for(500ms);
    // Once each kRecheckPeriod.
    EXPECT_LT(driver.wakes() - before, 40);
}

TEST(LabCanFaults, APeerThatIsDownIsAnInterfaceThatIsDown) {
    const PacedBus bus(125'000);
    const auto link = open_link(bus.near());
    LinkDriver driver(*link);
    EXPECT_EQ(driver.write(), WriteStatus::written);
    set_link_down(bus.far());
    EXPECT_TRUE(driver.run_until([&] {
        driver.write();
        return driver.status().state == CanBusState::down;
    }));
    EXPECT_EQ(driver.write(), WriteStatus::unavailable);
    set_link_up(bus.far());
    record(time_to_next_written(driver));
}

TEST(LabCanFaults, ADeviceThatIsRemovedIsLostAndCanBeOpenedAgain) {
    VirtualBus bus;
    auto link = open_link(bus.name());
    LinkDriver driver(*link);
    bus.remove();
    EXPECT_TRUE(driver.run_until([&] { return driver.latest_read() == ReadStatus::lost; }));
    EXPECT_EQ(driver.write(), WriteStatus::lost);
    EXPECT_FALSE(CanSocket::open(bus.name(), usual_settings()));
    bus.create();
    EXPECT_EQ(driver.write(), WriteStatus::lost) << "the removed device is another one now";
    link = open_link(bus.name());
    LinkDriver again(*link);
    EXPECT_EQ(again.write(), WriteStatus::written);
}

TEST(LabCanFaults, ADeviceThatIsRemovedIsLostForASenderThatNeverReads) {
    VirtualBus bus;
    const auto link = open_link(bus.name());
    LinkDriver driver(*link);
    bus.remove();
    EXPECT_EQ(driver.write(), WriteStatus::lost);
}

TEST(LabCanFaults, ADeviceWhoseNameIsThatOfAnotherOneIsLostAndTheOtherOneIsOpened) {
    const VirtualBus one("vcan0");
    const VirtualBus other("vcan1");
    auto link = open_link("vcan0");
    LinkDriver driver(*link);
    EXPECT_EQ(driver.write(), WriteStatus::written);
    RawCan elsewhere("vcan0");
    swap_names("vcan0", "vcan1");
    EXPECT_EQ(driver.write(), WriteStatus::lost);
    EXPECT_EQ(elsewhere.receive_all().size(), 0U) << "it sent to a bus that has another name now";
    RawCan meant("vcan0");
    link = open_link("vcan0");
    LinkDriver again(*link);
    EXPECT_EQ(again.write(), WriteStatus::written);
    EXPECT_TRUE(meant.receive());
}

TEST(LabCanFaults, ADeviceWhoseNameIsThatOfAnotherOneGivesNothingMoreThatWaits) {
    const VirtualBus one("vcan0");
    const VirtualBus other("vcan1");
    auto link = open_link("vcan0");
    LinkDriver driver(*link);
    swap_names("vcan0", "vcan1");
    RawCan elsewhere("vcan1");
    EXPECT_EQ(elsewhere.send(make_frame(0x123, {1, 2, 3, 4, 5, 6, 7, 8})), 0);
    EXPECT_TRUE(driver.run_until([&] { return driver.latest_read() == ReadStatus::lost; }));
    EXPECT_EQ(driver.counts().received, 0U);
}

TEST(LabCanFaults, ErrorFramesBecomeStates) {
    SlcanAdapter adapter;
    const auto link = open_link(adapter.name());
    LinkDriver driver(*link);
    EXPECT_EQ(driver.status().state, CanBusState::ready);
    adapter.error_warning();
    EXPECT_TRUE(driver.run_until_state(CanBusState::warning));
    adapter.error_passive();
    EXPECT_TRUE(driver.run_until_state(CanBusState::passive));
    EXPECT_EQ(driver.write(1), WriteStatus::written);
    adapter.error_active();
    EXPECT_TRUE(driver.run_until_state(CanBusState::ready));
    adapter.missing_acknowledge();
    EXPECT_TRUE(driver.run_until([&] { return driver.counts().missing_acknowledges == 1; }));
    EXPECT_GE(driver.counts().error_frames, 4U);
    EXPECT_EQ(driver.status().state, CanBusState::ready);
}

TEST(LabCanFaults, InBusOffNothingIsSentUntilTheControllerIsRestarted) {
    SlcanAdapter adapter;
    const auto link = open_link(adapter.name());
    LinkDriver driver(*link);
    EXPECT_EQ(driver.write(1), WriteStatus::written);
    EXPECT_TRUE(eventually([&] { return adapter.heard().back().starts_with("t300"); }));
    adapter.bus_off();
    ASSERT_TRUE(driver.run_until_state(CanBusState::bus_off));
    EXPECT_EQ(driver.counts().bus_offs, 1U);
    const std::size_t heard = adapter.heard().size();
    const auto sent = driver.counts().sent;
    const auto fates = driver.stream_for(CanTransmitter::kProbePeriod + 1500ms);
    EXPECT_EQ(count(fates, WriteStatus::unavailable), std::ssize(fates));
    EXPECT_EQ(driver.status().state, CanBusState::bus_off);
    EXPECT_EQ(adapter.heard().size(), heard);
    EXPECT_EQ(driver.counts().sent, sent) << "a frame was sent that the kernel drops";

    set_link_down(adapter.name());
    set_link_up(adapter.name());
    record(time_to_next_written(driver));
    driver.stream_for(100ms);
    EXPECT_EQ(driver.status().state, CanBusState::ready);
    EXPECT_TRUE(driver.run_until([&] { return adapter.heard().back().starts_with("t303"); }));
}

TEST(LabCanFaults, ARestartFrameEndsABusOff) {
    const VirtualBus bus;
    RawCan injector(bus.name());
    const auto link = open_link(bus.name());
    LinkDriver driver(*link);
    ASSERT_EQ(injector.send_error(CAN_ERR_BUSOFF), 0);
    ASSERT_TRUE(driver.run_until_state(CanBusState::bus_off));
    EXPECT_EQ(driver.write(), WriteStatus::unavailable);
    ASSERT_EQ(injector.send_error(CAN_ERR_RESTARTED), 0);
    EXPECT_TRUE(driver.run_until_state(CanBusState::ready));
    record(time_to_next_written(driver));
}

TEST(LabCanFaults, ABusOffWhoseEndNobodyTellsIsProbed) {
    const VirtualBus bus;
    RawCan injector(bus.name());
    const auto link = open_link(bus.name());
    LinkDriver driver(*link);
    ASSERT_EQ(injector.send_error(CAN_ERR_BUSOFF), 0);
    ASSERT_TRUE(driver.run_until_state(CanBusState::bus_off));
    const Duration time = time_to_next_written(driver);
    record(time);
    EXPECT_GT(time, CanTransmitter::kProbePeriod - 100ms);
    EXPECT_LT(time, CanTransmitter::kProbePeriod + 2s);
    EXPECT_EQ(driver.status().state, CanBusState::ready);
}

TEST(LabCanFaults, AnAdapterThatTakesNothingIsAStallAndItsQueueHoldsFewOldFrames) {
    SlcanAdapter adapter;
    const auto link = open_link(adapter.name());
    LinkDriver driver(*link);
    driver.stream_for(50ms);
    adapter.block();
    ASSERT_TRUE(driver.run_until([&] {
        driver.write();
        return driver.status().state == CanBusState::stalled;
    }));
    const std::size_t heard = adapter.heard().size();
    const auto sent = driver.counts().sent;
    const Instant stalled = monotonic_now();
    driver.stream_for(500ms);
    // On a busy machine this takes long enough for some probes.
    const auto probes = 1 + (monotonic_now() - stalled) / CanTransmitter::kProbePeriod;
    EXPECT_LE(driver.counts().sent, sent + static_cast<std::uint64_t>(probes));
    EXPECT_EQ(driver.counts().queue_full, 0U);
    adapter.unblock();
    record(time_to_next_written(driver));
    EXPECT_EQ(driver.status().state, CanBusState::ready);
    EXPECT_TRUE(eventually([&] { return adapter.heard().size() > heard; }));
}

}  // namespace
}  // namespace tribus::test::can_socket_faults_test
