#include <algorithm>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/loopback/loopback.h"

/// The built program on real drivers: i.Bus in at a 16550, SBUS out at an FTDI adapter.
namespace tribus::test::serial_program_test {
namespace {

class LabProgram : public Loopback {
  protected:
    std::string config(const std::string& receiver, const std::string& servos) {
        return write_config("[input.receiver]\nprotocol = \"ibus\"\ntimeout = \"5s\"\ndevice = \"" +
                            receiver + "\"\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"" +
                            servos + "\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n");
    }
};

/// Sends an i.Bus frame every few milliseconds until the SBUS frame with its channels arrives.
bool passes(Uart& receiver, Uart& servos, const Sticks& sticks) {
    const Bytes ibus = ibus_bytes(sticks);
    const Bytes sbus = sbus_bytes(sbus_sight_of(sticks));
    Bytes seen;
    auto latest = Clock::time_point{};
    return eventually([&] {
        if (Clock::now() - latest > std::chrono::milliseconds(7)) {
            latest = Clock::now();
            receiver.send(ibus);
        }
        const Bytes more = servos.receive();
        seen.insert(seen.end(), more.begin(), more.end());
        return std::search(seen.begin(), seen.end(), sbus.begin(), sbus.end()) != seen.end();
    });
}

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
