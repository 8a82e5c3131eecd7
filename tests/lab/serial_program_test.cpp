#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/lab/wired_ports.h"

/// The built program on real drivers: i.Bus in at a 16550, SBUS out at an FTDI adapter.
namespace tribus::test::serial_program_test {
namespace {

using LabProgram = WiredPorts;

TEST_F(LabProgram, TranslatesIbusToSbusBetweenRealPorts) {
    Uart receiver(uart_16550(2), kIbus);
    Uart servos(ftdi_adapter(2), kSbus);
    const ProgrammedLines lines;
    Program& program = run(config(uart_16550(1), ftdi_adapter(1)));
    lines.expect("baudrate=115200 parity='N' data=8 stop=1");
    lines.expect("parity E, data bits 8, stop bits 2");
    lines.expect("baud rate 100000");
    EXPECT_TRUE(passes(receiver, servos, sticks_with_first(1200))) << program.errors();
    EXPECT_TRUE(passes(receiver, servos, sticks_with_first(1800))) << program.errors();
    expect_clean_end(program);
}

TEST_F(LabProgram, GoesOnAfterItsAdapterWasUnpluggedAndPluggedAgain) {
    Uart receiver(uart_16550(2), kIbus);
    Uart servos(ftdi_adapter(2), kSbus);
    // A link as udev makes it under /dev/serial/by-id, because the adapter's number may change.
    const std::string adapter = folder() / "adapter";
    std::filesystem::create_symlink(ftdi_adapter(1), adapter);
    Program& program = run(config(uart_16550(1), adapter));
    EXPECT_TRUE(passes(receiver, servos, sticks_with_first(1200))) << program.errors();
    std::filesystem::remove(adapter);
    unplug_usb(1);
    EXPECT_TRUE(program.says(adapter)) << program.errors();
    plug_usb(1);
    std::filesystem::create_symlink(ftdi_adapter(1), adapter);
    EXPECT_TRUE(passes(receiver, servos, sticks_with_first(1800))) << program.errors();
    expect_clean_end(program);
}

TEST_F(LabProgram, NamesThePortThatCannotDoSbus) {
    const std::string port = uart_16550(1);
    Program& program = start({"run", config(ftdi_adapter(1), port)});
    EXPECT_EQ(program.end(), 1);
    EXPECT_NE(program.errors().find(port + ": asked for 100000 baud, but the port runs at 115200"),
              std::string::npos)
        << program.errors();
}

}  // namespace
}  // namespace tribus::test::serial_program_test
