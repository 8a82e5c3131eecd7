#include <chrono>
#include <string>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/loopback/loopback.h"
#include "tests/loopback/recorded_sensors.h"
#include "tests/loopback/sensor_bus.h"

/// The built program as sensors at an emulated UART.
namespace tribus::test::serial_sensor_bus_test {
namespace {

constexpr LineSettings kSensorLine{.baud = 115'200, .parity = Parity::none, .stop_bits = 1};
/// An emulated machine has pauses, in which requests wait.
constexpr std::chrono::milliseconds kSlot{20};

class SensorUart : public Loopback {};

TEST_F(SensorUart, AnswersTheRecordedReceiverAsTheRecordedSensorsByteForByte) {
    Uart port(uart_16550(2), kSensorLine);
    Asker receiver({.send = [&](const Bytes& bytes) { port.send(bytes); },
                    .receive = [&] { return port.receive(); }},
                   FarWires::two, kSlot);
    const ProgrammedLines lines;
    Program& program =
        run(write_config("[sensor_bus.telemetry]\nrole = \"sensor\"\n"
                         "wires = \"two\"\nreply_within = \"3ms\"\ndevice = \"" +
                         uart_16550(1) + "\"\n" + std::string(kRecordedSensors)));
    lines.expect("baudrate=115200 parity='N' data=8 stop=1");
    for (const Capture capture : captures()) {
        expect_recorded_answers(receiver, recorded_exchanges(200, capture));
    }
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::serial_sensor_bus_test
