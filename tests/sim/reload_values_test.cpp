#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tests/sim/reload_run.h"
#include "tests/support/ibus_checksum.h"

/// Sensor buses and sensor values across a reload.
namespace tribus::test::reload_values_test {
namespace {

using namespace std::chrono_literals;

Instant at(Duration since_start) {
    return Instant(since_start);
}

std::string bus(const std::string& name, const std::string& lines) {
    return "[sensor_bus." + name + "]\ndevice = \"/dev/tty" + name + "\"\nwires = \"two\"\n" +
           lines;
}

/// Adds another bus before or after this one, so that its index changes.
std::string with_another(const std::string& job, bool in_front) {
    const std::string another = bus("another", "role = \"receiver\"\n");
    return in_front ? another + job : job + another;
}

/// Answers as a temperature sensor of 21.5 degrees at address 1 (docs/protocols/ibus.md, "Sensor
/// bus: frames").
std::vector<std::uint8_t> answer_to(std::span<const std::uint8_t> request) {
    if (request.size() != 4 || (request[1] & 0x0F) != 1) {
        return {};
    }
    switch (request[1] >> 4) {
        case 8:
            return with_ibus_checksum({4, request[1]});
        case 9:
            return with_ibus_checksum({6, request[1], 0x01, 2});
        case 10:
            return with_ibus_checksum({6, request[1], 0x6F, 0x02});
        default:
            return {};
    }
}

const std::string kProbes = bus("probes", "role = \"receiver\"\n");

/// Returns the receiver's requests in three seconds while the sensor answers; with a reload every
/// 33 ms or without reloads.
std::vector<Said> talk(bool reloads) {
    ReloadRun run(with_another(kProbes, false));
    std::size_t heard = 0;
    bool in_front = false;
    for (int millisecond = 1; millisecond < 3000; ++millisecond) {
        const Instant now = at(millisecond * 1ms);
        run.run_until(now);
        if (reloads && millisecond % 33 == 0) {
            in_front = !in_front;
            run.reload(with_another(kProbes, in_front), now);
        }
        const auto& said = run.said("probes");
        if (said.size() > heard) {
            heard = said.size();
            const auto answer = answer_to(said.back().bytes);
            run.receive_on_bus("probes", answer, now);
        }
        if (millisecond > 1000) {
            EXPECT_EQ(run.bus_state("probes").found_count, 1U) << millisecond;
            EXPECT_TRUE(run.value("probes.temperature", now)) << millisecond;
        }
    }
    EXPECT_EQ(run.allocations(), 0U);
    return run.said("probes");
}

TEST(ReloadOfValues, GoesOnWithAnUnchangedSensorBusRequestByRequest) {
    const auto expected = talk(false);
    EXPECT_GT(expected.size(), 300U);
    EXPECT_EQ(talk(true), expected);
}

TEST(ReloadOfValues, BeginsAChangedSensorBusAnew) {
    ReloadRun run(kProbes);
    run.run_until(at(2s));
    EXPECT_GT(run.bus_state("probes").receiver.requests, 100U);
    run.reload(kProbes + "probe_every = 7\n", at(2s));
    EXPECT_LE(run.bus_state("probes").receiver.requests, 1U);
}

TEST(ReloadOfValues, KeepsTheAnswersOfAnUnchangedRoleOfSensors) {
    const std::string job = bus("telemetry", R"(role = "sensor"
[[sensor_bus.telemetry.sensor]]
type = "external_voltage"
value = "battery"
[values.battery]
constant = 11.1
unit = "V"
)");
    ReloadRun run(with_another(job, false));
    bool in_front = false;
    for (int request = 1; request <= 50; ++request) {
        const Instant now = at(request * 8ms);
        const auto asked = with_ibus_checksum({4, 0xA1});
        run.receive_on_bus("telemetry", std::span(asked).first(2), now);
        in_front = !in_front;
        run.reload(with_another(job, in_front), now + 100us);
        run.receive_on_bus("telemetry", std::span(asked).subspan(2), now + 200us);
    }
    run.run_until(at(1s));
    EXPECT_EQ(run.said("telemetry").size(), 50U);
    EXPECT_EQ(run.bus_state("telemetry").sensor.answered, 50U);
    EXPECT_EQ(run.allocations(), 0U);
}

}  // namespace
}  // namespace tribus::test::reload_values_test
