#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"
#include "tests/loopback/sensor_bus.h"
#include "tests/reference/plain_crsf.h"
#include "tests/reference/plain_exbus_telemetry.h"

/// Values between an i.Bus sensor bus and CRSF, through the built program over ptys, with plain
/// codecs at the far ends.
namespace tribus::test::telemetry_test {
namespace {

using reference::plain_crsf;

// docs/protocols/ibus.md, "Sensor types"
constexpr std::uint8_t kExternalVoltage = 0x03;

class TelemetryBothWays : public Loopback {};

/// An i.Bus sensor's 12.34 V is 12.3 V on the handset (docs/protocols/crsf.md, "Telemetry").
TEST_F(TelemetryBothWays, ASensorOnTheBusComesToTheReceiverAsBattery) {
    SensorString sensors(device("probes"), FarWires::two, {{kExternalVoltage, {0xD2, 0x04}}});
    FarEnd& radio = device("radio");
    FarEnd& servos = device("servos");
    Program& program = run(write_config(R"(
[sensor_bus.probes]
device = "@probes"
role = "receiver"
wires = "two"

[input.radio]
protocol = "crsf"
device = "@radio"

[output.handset]
protocol = "crsf-telemetry"
device = "@radio"
battery = { voltage = "probes.external_voltage" }

[output.servos]
protocol = "sbus"
device = "@servos"

[pipeline.main]
from = "radio"
to = "servos"
)"));
    const Bytes battery = plain_crsf(0xC8, 0x08, {0, 123, 0, 0, 0, 0, 0, 0});
    Bytes heard;
    EXPECT_TRUE(eventually([&] {
        const Bytes more = radio.receive();
        heard.insert(heard.end(), more.begin(), more.end());
        servos.receive();
        const auto frames = reference::plain_crsf_frames(heard);
        return !frames.empty() && frames.front().type == 0x08;
    })) << program.errors();
    ASSERT_GE(heard.size(), battery.size());
    EXPECT_TRUE(std::equal(battery.begin(), battery.end(), heard.begin()));
    expect_clean_end(program);
}

/// A flight controller's 16.8 V becomes a sensor that the i.Bus receiver asks, and is no longer
/// there when the controller has stopped.
TEST_F(TelemetryBothWays, ABatteryOfAFlightControllerBecomesASensorAndEndsWithIt) {
    FarEnd& controller = device("controller");
    FarEnd& bus = device("sensors");
    Asker receiver(bus, FarWires::two);
    Program& program = run(write_config(R"(
[values.fc]
protocol = "crsf-telemetry"
device = "@controller"
timeout = "300ms"

[sensor_bus.telemetry]
device = "@sensors"
role = "sensor"
wires = "two"
sensor = [{ type = "battery_current", value = "fc.battery.current" }]
)"));
    const Bytes battery = plain_crsf(0xC8, 0x08, {0, 168, 0, 25, 0, 0, 0, 0});
    EXPECT_TRUE(eventually([&] {
        controller.send(battery);
        return receiver.ask(0xA1) == value_reply(1, 250);
    })) << program.errors();
    EXPECT_TRUE(eventually([&] { return receiver.ask(0xA1).empty(); }));
    EXPECT_TRUE(eventually([&] {
        controller.send(battery);
        return receiver.ask(0xA1) == value_reply(1, 250);
    }));
    expect_clean_end(program);
}

/// A constant is on the display of a Jeti transmitter, and channels come from the same wire
/// (docs/protocols/exbus.md, "Telemetry").
TEST_F(TelemetryBothWays, AJetiReceiverThatAsksGetsAValueBesideItsChannels) {
    FarEnd& receiver = device("jeti");
    FarEnd& servos = device("servos");
    Program& program = run(write_config(R"(
[values.supply]
constant = 12.6

[input.radio]
protocol = "exbus"
device = "@jeti"

[output.display]
protocol = "exbus-telemetry"
device = "@jeti"
sensors = { 3 = { value = "supply", label = "Supply", unit = "V" } }

[output.servos]
protocol = "sbus"
device = "@servos"

[pipeline.main]
from = "radio"
to = "servos"
)"));
    std::uint8_t packet = 0;
    std::vector<std::string> names;
    bool moves = false;
    EXPECT_TRUE(eventually([&] {
        receiver.send(reference::plain_exbus_channels(std::vector<std::uint16_t>(16, 8066)));
        ::usleep(4000);
        receiver.send(reference::plain_exbus_request(++packet));
        // A receiver waits for 8 ms; as long as this a busy machine may take.
        auto bytes = receiver.receive();
        auto answer = reference::plain_exbus_answer(bytes);
        for (int waited_ms = 0; !answer && waited_ms < 50; ++waited_ms) {
            ::usleep(1000);
            const auto more = receiver.receive();
            bytes.insert(bytes.end(), more.begin(), more.end());
            answer = reference::plain_exbus_answer(bytes);
        }
        moves = moves || servos.receive().size() >= 25;
        // An answer that came late, or none, is a request without an answer.
        if (!answer || answer->packet != packet) {
            return false;
        }
        if (answer->named) {
            names.push_back(answer->label + " " + answer->unit);
        }
        return answer->numbers == std::map<unsigned, double>{{3, 12.6}};
    })) << program.errors();
    EXPECT_EQ(names, (std::vector<std::string>{"tribus ", "Supply V"}));
    EXPECT_TRUE(moves);
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::telemetry_test
