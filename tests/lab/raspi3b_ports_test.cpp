#include <string>

#include <gtest/gtest.h>

#include "tests/lab/wired_ports.h"

/// The built program at the ports of an emulated Raspberry Pi 3 (run_raspi3b), with the drivers of
/// Debian's kernel for arm64.
namespace tribus::test::raspi3b_ports_test {
namespace {

constexpr const char* kPl011 = "/dev/ttyAMA0";
constexpr const char* kMiniUart = "/dev/ttyS1";

using RaspberryPi3 = WiredPorts;

TEST_F(RaspberryPi3, DoctorHearsSbusAtThePl011) {
    Uart sender(far_end_of_pl011(), kSbus);
    const std::string said =
        said_of(kPl011, sender, sbus_bytes(sbus_sight_of(sticks_with_first(1200))), 0);
    EXPECT_TRUE(has(said, ": PL011 of the board")) << said;
    EXPECT_TRUE(has(said, "takes    i.Bus, SBUS (through an inverter)")) << said;
    EXPECT_TRUE(has(said, "hears    SBUS, 16 channels and 2 switches, 100000 baud 8E2")) << said;
}

TEST_F(RaspberryPi3, DoctorSaysThatTheMiniUartCannotDoSbus) {
    Uart sender(far_end_of_mini_uart(), kIbus);
    const std::string said = said_of(kMiniUart, sender, ibus_bytes(sticks_with_first(1200)), 0);
    EXPECT_TRUE(has(said, ": mini UART of a Raspberry Pi")) << said;
    EXPECT_TRUE(has(said, "cannot   SBUS")) << said;
    EXPECT_TRUE(has(said, "port.mini_uart")) << said;
    EXPECT_TRUE(has(said, "hears    i.Bus, 18 channels, 115200 baud 8N1")) << said;
}

TEST_F(RaspberryPi3, TranslatesIbusAtTheMiniUartToSbusAtThePl011) {
    Uart receiver(far_end_of_mini_uart(), kIbus);
    Uart servos(far_end_of_pl011(), kSbus);
    Program& program = run(config(kMiniUart, kPl011));
    EXPECT_TRUE(passes(receiver, servos, sticks_with_first(1200))) << program.errors();
    EXPECT_TRUE(passes(receiver, servos, sticks_with_first(1800))) << program.errors();
    expect_clean_end(program);
}

TEST_F(RaspberryPi3, NamesTheMiniUartThatDropsTheParityOfSbus) {
    Program& program = start({"run", config(kPl011, kMiniUart)});
    EXPECT_EQ(program.end(), 1);
    EXPECT_TRUE(has(program.errors(), std::string(kMiniUart) +
                                          ": asked for even parity, but the port drops the parity "
                                          "bit"))
        << program.errors();
}

}  // namespace
}  // namespace tribus::test::raspi3b_ports_test
