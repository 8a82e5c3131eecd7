#include <chrono>
#include <string>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/lab/wired_ports.h"

/// `tribus doctor` at ports with real drivers.
namespace tribus::test::serial_doctor_test {
namespace {

using LabDoctor = WiredPorts;

TEST_F(LabDoctor, HearsSbusAtAnFtdiAdapter) {
    Uart sender(ftdi_adapter(2), kSbus);
    const std::string said =
        said_of(ftdi_adapter(1), sender, sbus_bytes(sbus_sight_of(sticks_with_first(1200))), 0);
    EXPECT_TRUE(has(said, ": USB adapter, FTDI")) << said;
    EXPECT_TRUE(has(said, "takes    i.Bus, SBUS (through an inverter)")) << said;
    EXPECT_TRUE(has(said, "hears    SBUS, 16 channels and 2 switches, 100000 baud 8E2")) << said;
    EXPECT_EQ(sender.receive(), Bytes{}) << "doctor wrote to the wire";
}

TEST_F(LabDoctor, AsksAnFtdiAdapterForItsShortTimer) {
    const std::string device = ftdi_adapter(1);
    Uart sender(ftdi_adapter(2), kIbus);
    // The state after the adapter was plugged in.
    unplug_usb(1);
    plug_usb(1);
    const std::string said =
        said_of(ftdi_adapter(1), sender, ibus_bytes(sticks_with_first(1200)), 0);
    EXPECT_FALSE(has(said, "port.latency_timer")) << said;
}

TEST_F(LabDoctor, HearsIbusAtA16550ThatCannotDoSbus) {
    Uart sender(uart_16550(2), kIbus);
    const std::string said = said_of(uart_16550(1), sender, ibus_bytes(sticks_with_first(1200)), 0);
    EXPECT_TRUE(has(said, ": 16550 at 115200 baud")) << said;
    EXPECT_TRUE(has(said, "takes    i.Bus, sensor bus")) << said;
    EXPECT_TRUE(has(said, "cannot   SBUS (asked for 100000 baud")) << said;
    EXPECT_TRUE(has(said, "hears    i.Bus, 18 channels, 115200 baud 8N1")) << said;
    EXPECT_EQ(sender.receive(), Bytes{}) << "doctor wrote to the wire";
}

TEST_F(LabDoctor, HearsNothingAtA16550ThatCannotDoSbusWhereNobodySends) {
    Uart sender(uart_16550(2), kIbus);
    {
        // Bytes from the previous test may still be on their way.
        Uart drained(uart_16550(1), kIbus);
        auto latest = Clock::now();
        EXPECT_TRUE(eventually([&] {
            latest = drained.receive().empty() ? latest : Clock::now();
            return Clock::now() - latest > std::chrono::milliseconds(300);
        }));
    }
    const std::string said = said_of(uart_16550(1), sender, {}, 1);
    EXPECT_TRUE(has(said, "hears    nothing")) << said;
    EXPECT_FALSE(has(said, "port.cannot_open")) << said;
}

TEST_F(LabDoctor, ListsTheAdaptersAndWhatTheyCanDo) {
    const std::string usb = ftdi_adapter(1);
    const std::string uart = uart_16550(1);
    const ShellResult result = run_shell(std::string(TRIBUS_PROGRAM) + " doctor");
    EXPECT_TRUE(has(result.output, usb + ": USB adapter, FTDI")) << result.output;
    EXPECT_TRUE(has(result.output, uart + ": 16550 at 115200 baud")) << result.output;
    EXPECT_TRUE(has(result.output, "cannot   SBUS (it would run at 115200 baud)")) << result.output;
    EXPECT_TRUE(has(result.output, "[machine.kernel_not_realtime]")) << result.output;
    EXPECT_TRUE(has(result.output, "apt install linux-image-rt-amd64")) << result.output;
}

TEST_F(LabDoctor, LeavesTheConsoleAlone) {
    require_guest();
    const ShellResult result = run_shell(std::string(TRIBUS_PROGRAM) + " doctor /dev/ttyS0");
    EXPECT_EQ(result.status, 1) << result.output;
    EXPECT_TRUE(has(result.output, "[port.kernel_console]")) << result.output;
    EXPECT_FALSE(has(result.output, "hears")) << result.output;
}

TEST_F(LabDoctor, SaysWhoHasAPortOpen) {
    const Uart user(ftdi_adapter(1), kSbus);
    const ShellResult result =
        run_shell(std::string(TRIBUS_PROGRAM) + " doctor " + ftdi_adapter(1));
    EXPECT_EQ(result.status, 1) << result.output;
    EXPECT_TRUE(has(result.output, "it is in use by lab_serial_test")) << result.output;
}

}  // namespace
}  // namespace tribus::test::serial_doctor_test
