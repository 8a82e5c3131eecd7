#include "transports/links/can/can_interface.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

/// An interface in one line, and what to change on it.
namespace tribus::can_interface_advice_test {
namespace {

using Sentences = std::vector<std::string>;

/// A controller that is set up well for RC.
CanInterface good_controller() {
    CanInterface interface;
    interface.name = "can0";
    interface.kind = "can";
    interface.index = 7;
    interface.is_can = true;
    interface.up = true;
    interface.lower_up = true;
    interface.echo = true;
    interface.mtu = 16;
    interface.queue_length = 10;
    interface.bit_rate = 500000;
    interface.sample_point_permille = 875;
    interface.restart_ms = 100;
    interface.state = CanControllerState::active;
    interface.transmit_errors = 0;
    interface.receive_errors = 0;
    return interface;
}

CanInterface virtual_bus() {
    CanInterface interface;
    interface.name = "vcan0";
    interface.kind = "vcan";
    interface.is_can = true;
    interface.up = true;
    interface.lower_up = true;
    interface.mtu = 72;
    return interface;
}

testing::AssertionResult advises(const CanInterface& interface, const std::string& command,
                                 bool sends = true, bool fd_wanted = false) {
    const auto sentences = advice(interface, sends, fd_wanted);
    if (sentences.size() == 1 && sentences[0].find(command) != std::string::npos) {
        return testing::AssertionSuccess();
    }
    return testing::AssertionFailure() << testing::PrintToString(sentences);
}

TEST(CanInterfaceAdvice, HasNothingToSayAboutAGoodController) {
    EXPECT_TRUE(advice(good_controller(), true, false).empty());
}

TEST(CanInterfaceAdvice, HasNothingToSayAboutAVirtualBus) {
    EXPECT_TRUE(advice(virtual_bus(), true, true).empty());
}

TEST(CanInterfaceAdvice, NoRestartAfterBusOff) {
    CanInterface interface = good_controller();
    interface.restart_ms = 0;
    EXPECT_TRUE(advises(interface, "`ip link set can0 type can restart-ms 100`"));
}

TEST(CanInterfaceAdvice, DownWithAndWithoutBitRate) {
    CanInterface interface = good_controller();
    interface.up = false;
    interface.lower_up = false;
    EXPECT_TRUE(advises(interface, "`ip link set can0 up`"));
    interface.bit_rate.reset();
    EXPECT_TRUE(advises(interface, "`ip link set can0 up type can bitrate 1000000`"));
}

TEST(CanInterfaceAdvice, NoCarrier) {
    CanInterface interface = virtual_bus();
    interface.lower_up = false;
    EXPECT_TRUE(advises(interface, "no carrier"));
}

TEST(CanInterfaceAdvice, BusOff) {
    CanInterface interface = good_controller();
    interface.state = CanControllerState::bus_off;
    interface.lower_up = false;
    EXPECT_TRUE(advises(interface, "`ip link set can0 type can restart`"));
}

TEST(CanInterfaceAdvice, ALongQueueWhereWeSend) {
    CanInterface interface = good_controller();
    interface.queue_length = 1000;
    EXPECT_TRUE(advises(interface, "`ip link set can0 txqueuelen 16`"));
    EXPECT_TRUE(advice(interface, false, false).empty());
}

TEST(CanInterfaceAdvice, ListenOnlyWhereWeSend) {
    CanInterface interface = good_controller();
    interface.listen_only = true;
    EXPECT_TRUE(advises(interface, "`ip link set can0 type can listen-only off`"));
    EXPECT_TRUE(advice(interface, false, false).empty());
}

TEST(CanInterfaceAdvice, LoopbackAndOneShotWhereWeSend) {
    CanInterface interface = good_controller();
    interface.one_shot = true;
    EXPECT_TRUE(advises(interface, "`ip link set can0 type can one-shot off`"));
    interface.one_shot = false;
    interface.loopback = true;
    EXPECT_TRUE(advises(interface, "`ip link set can0 type can loopback off`"));
}

TEST(CanInterfaceAdvice, FdOnAControllerNeedsItsModeAndOnAVirtualBusTheMtu) {
    EXPECT_TRUE(advises(good_controller(), "bitrate 500000 dbitrate 4000000 fd on`", true, true));
    CanInterface interface = virtual_bus();
    interface.mtu = 16;
    EXPECT_TRUE(advises(interface, "`ip link set vcan0 mtu 72`", true, true));
    EXPECT_EQ(fd_problem(virtual_bus()), std::nullopt);
}

TEST(CanInterfaceSummary, IsOneLineWithAllThatIsKnown) {
    CanInterface interface = good_controller();
    interface.data_bit_rate = 4000000;
    interface.mtu = 72;
    interface.transmit_errors = 12;
    EXPECT_EQ(summary(interface),
              "can0: can, up, 500 kbit/s (data 4000 kbit/s), sample point 87.5 %, MTU 72 (FD), "
              "queue 10, restart-ms 100, error-active, error counters 12 sending, 0 receiving");
}

TEST(CanInterfaceSummary, LeavesOutWhatAVirtualBusDoesNotHave) {
    EXPECT_EQ(summary(virtual_bus()), "vcan0: vcan, up, MTU 72 (FD), queue 0");
}

TEST(CanInterfaceSummary, SaysThatAnInterfaceIsDown) {
    CanInterface interface = virtual_bus();
    interface.up = false;
    interface.lower_up = false;
    EXPECT_EQ(summary(interface), "vcan0: vcan, down, MTU 72 (FD), queue 0");
}

TEST(CanInterfaceSummary, SaysThatAnInterfaceThatIsUpHasNoCarrier) {
    CanInterface interface = virtual_bus();
    interface.lower_up = false;
    EXPECT_EQ(summary(interface), "vcan0: vcan, up without carrier, MTU 72 (FD), queue 0");
}

TEST(CanInterfaceSummary, CallsAnInterfaceOfAnUnknownKindACanInterface) {
    CanInterface interface = virtual_bus();
    interface.kind.clear();
    interface.mtu = 16;
    EXPECT_EQ(summary(interface), "vcan0: CAN interface, up, MTU 16, queue 0");
}

TEST(CanInterfaceSummary, ShowsABitRateThatIsNoWholeNumberOfKilobitsInBits) {
    CanInterface interface = virtual_bus();
    interface.bit_rate = 83333;
    interface.sample_point_permille = 801;
    EXPECT_EQ(summary(interface),
              "vcan0: vcan, up, 83333 bit/s, sample point 80.1 %, MTU 72 (FD), queue 0");
}

TEST(CanInterfaceSummary, LeavesOutWhatOfARateIsNotKnown) {
    CanInterface interface = virtual_bus();
    interface.bit_rate = 1000000;
    EXPECT_EQ(summary(interface), "vcan0: vcan, up, 1000 kbit/s, MTU 72 (FD), queue 0");
}

TEST(CanInterfaceSummary, ShowsThatAControllerDoesNotRestart) {
    CanInterface interface = virtual_bus();
    interface.restart_ms = 0;
    EXPECT_EQ(summary(interface), "vcan0: vcan, up, MTU 72 (FD), queue 0, restart-ms 0");
}

TEST(CanInterfaceSummary, CountsNoErrorsWhereOneCounterIsNotKnown) {
    CanInterface interface = virtual_bus();
    interface.transmit_errors = 7;
    EXPECT_EQ(summary(interface),
              "vcan0: vcan, up, MTU 72 (FD), queue 0, error counters 7 sending, 0 receiving");
    interface.transmit_errors.reset();
    interface.receive_errors = 5;
    EXPECT_EQ(summary(interface),
              "vcan0: vcan, up, MTU 72 (FD), queue 0, error counters 0 sending, 5 receiving");
}

struct NamedState {
    CanControllerState state;
    const char* name;
};

class CanControllerStateInTheSummary : public ::testing::TestWithParam<NamedState> {};

TEST_P(CanControllerStateInTheSummary, HasItsName) {
    CanInterface interface = virtual_bus();
    interface.state = GetParam().state;
    EXPECT_EQ(summary(interface),
              std::string("vcan0: vcan, up, MTU 72 (FD), queue 0, ") + GetParam().name);
}

INSTANTIATE_TEST_SUITE_P(Each, CanControllerStateInTheSummary,
                         testing::Values(NamedState{CanControllerState::active, "error-active"},
                                         NamedState{CanControllerState::warning, "error-warning"},
                                         NamedState{CanControllerState::passive, "error-passive"},
                                         NamedState{CanControllerState::bus_off, "bus-off"},
                                         NamedState{CanControllerState::stopped, "stopped"},
                                         NamedState{CanControllerState::sleeping, "sleeping"},
                                         NamedState{CanControllerState{6}, "unknown"}));

TEST(CanInterfaceAdvice, SaysTheWholeCommandToBringItUp) {
    CanInterface interface = good_controller();
    interface.up = false;
    EXPECT_EQ(advice(interface, true, false), Sentences{"it is down: `ip link set can0 up`"});
    interface.bit_rate.reset();
    EXPECT_EQ(advice(interface, true, false),
              Sentences{"it is down: `ip link set can0 up type can bitrate 1000000` with the bit "
                        "rate of the bus"});
    CanInterface without = virtual_bus();
    without.up = false;
    EXPECT_EQ(advice(without, true, false), Sentences{"it is down: `ip link set vcan0 up`"});
}

TEST(CanInterfaceAdvice, TakesNoCarrierForGrantedInABusOffOnly) {
    CanInterface interface = good_controller();
    interface.lower_up = false;
    EXPECT_EQ(advice(interface, true, false),
              Sentences{"it has no carrier: its other end is not connected, or down"});
    interface.state = CanControllerState::bus_off;
    EXPECT_EQ(advice(interface, true, false),
              Sentences{"its controller is in bus-off and sends nothing: `ip link set can0 type "
                        "can restart`, then check bit rate, wiring and termination"});
}

TEST(CanInterfaceAdvice, AQueueOf64FramesIsNotTooLong) {
    CanInterface interface = good_controller();
    interface.queue_length = 64;
    EXPECT_EQ(advice(interface, true, false), Sentences{});
    interface.queue_length = 65;
    EXPECT_TRUE(advises(interface, "its queue holds 65 frames: "));
}

TEST(CanInterfaceAdvice, AControllerThatRestartsAfterAMillisecondIsWell) {
    CanInterface interface = good_controller();
    interface.restart_ms = 1;
    EXPECT_EQ(advice(interface, true, false), Sentences{});
    interface.restart_ms.reset();
    EXPECT_EQ(advice(interface, true, false), Sentences{}) << "not known";
}

TEST(CanInterfaceAdvice, CountsAllThatIsWrong) {
    CanInterface interface = good_controller();
    interface.restart_ms = 0;
    interface.listen_only = true;
    interface.loopback = true;
    interface.one_shot = true;
    interface.queue_length = 1000;
    EXPECT_EQ(advice(interface, true, true).size(), 6U);
    EXPECT_EQ(advice(interface, false, false).size(), 1U);
}

TEST(CanInterfaceFd, NeedsAnMtuOf72) {
    CanInterface interface = virtual_bus();
    EXPECT_EQ(fd_problem(interface), std::nullopt);
    interface.mtu = 71;
    EXPECT_EQ(fd_problem(interface),
              "FD frames are configured, but its MTU is 71: `ip link set vcan0 down`, `ip link set "
              "vcan0 mtu 72`, `ip link set vcan0 up`");
}

TEST(CanInterfaceFd, OnAControllerWithoutABitRateIsSetUpWithTheUsualOne) {
    CanInterface interface = good_controller();
    interface.bit_rate.reset();
    EXPECT_EQ(fd_problem(interface),
              "FD frames are configured, but its controller is not in FD mode: `ip link set can0 "
              "down`, `ip link set can0 type can bitrate 1000000 dbitrate 4000000 fd on`, `ip link "
              "set can0 up`, with the bit rates of the bus");
}

}  // namespace
}  // namespace tribus::can_interface_advice_test
