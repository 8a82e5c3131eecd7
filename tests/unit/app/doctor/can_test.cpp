#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "app/doctor/can_judge.h"
#include "tests/support/kernel_tree.h"

namespace tribus::doctor::can_test {
namespace {

using Ids = std::vector<std::string>;

/// A controller without problems.
CanInterface controller() {
    CanInterface interface;
    interface.name = "can0";
    interface.kind = "can";
    interface.is_can = interface.up = interface.lower_up = true;
    interface.mtu = 72;
    interface.queue_length = 16;
    interface.bit_rate = 500'000;
    interface.restart_ms = 100;
    interface.state = CanControllerState::active;
    return interface;
}

Ids ids(const CanInterface& interface) {
    Ids all;
    for (const Finding& finding : judge_can(interface, true)) {
        all.emplace_back(finding.id);
    }
    return all;
}

TEST(CanOfADoctor, ThatIsWellNeedsNothing) {
    EXPECT_EQ(ids(controller()), Ids{});
}

TEST(CanOfADoctor, ThatIsDownIsAProblemWithTheCommandThatEndsIt) {
    CanInterface interface = controller();
    interface.up = interface.lower_up = false;
    interface.bit_rate.reset();
    const auto findings = judge_can(interface, true);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].id, "can.down");
    EXPECT_EQ(findings[0].severity, Severity::problem);
    EXPECT_EQ(findings[0].commands,
              Ids{"sudo ip link set can0 up type can bitrate 1000000 restart-ms 100"});
}

TEST(CanOfADoctor, ThatNobodyAskedForMayBeDown) {
    CanInterface interface = controller();
    interface.up = interface.lower_up = false;
    EXPECT_EQ(judge_can(interface, false)[0].severity, Severity::advice);
}

TEST(CanOfADoctor, InBusOffIsRestarted) {
    CanInterface interface = controller();
    interface.lower_up = false;
    interface.state = CanControllerState::bus_off;
    EXPECT_EQ(ids(interface), Ids{"can.bus_off"});
}

TEST(CanOfADoctor, WithoutCarrierHasNobodyAtItsOtherEnd) {
    CanInterface interface = controller();
    interface.lower_up = false;
    EXPECT_EQ(ids(interface), Ids{"can.no_carrier"});
}

TEST(CanOfADoctor, ThatCountsErrorsIsToldWhatTheyMean) {
    CanInterface interface = controller();
    interface.state = CanControllerState::passive;
    interface.transmit_errors = 128;
    EXPECT_EQ(ids(interface), Ids{"can.errors"});
}

TEST(CanOfADoctor, ThatNeverRestartsIsToldHow) {
    CanInterface interface = controller();
    interface.restart_ms = 0;
    const auto findings = judge_can(interface, true);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].commands, (Ids{"sudo ip link set can0 down",
                                         "sudo ip link set can0 up type can restart-ms 100"}));
}

TEST(CanOfADoctor, ModesThatKeepFramesFromTheBusAreTold) {
    CanInterface interface = controller();
    interface.listen_only = interface.loopback = interface.one_shot = true;
    EXPECT_EQ(ids(interface), (Ids{"can.listen_only", "can.loopback", "can.one_shot"}));
}

TEST(CanOfADoctor, LongQueueIsTold) {
    CanInterface interface = controller();
    interface.queue_length = 1000;
    EXPECT_EQ(ids(interface), Ids{"can.long_queue"});
}

TEST(CanOfADoctor, WithoutFdIsWorthANote) {
    CanInterface interface = controller();
    interface.mtu = 16;
    EXPECT_EQ(ids(interface), Ids{"can.no_fd"});
}

TEST(CanOfADoctor, IsToldFromOtherNetworksByItsType) {
    const test::KernelTree tree;
    tree.write("sys/class/net/eth0/type", "1\n");
    tree.write("sys/class/net/vcan0/type", "280\n");
    tree.write("sys/class/net/can0/type", "280\n");
    EXPECT_EQ(can_interfaces(KernelFiles(tree.root())), (Ids{"can0", "vcan0"}));
}

}  // namespace
}  // namespace tribus::doctor::can_test
