#include "app/log/sensor_bus_log.h"

#include <chrono>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "config/load.h"
#include "pipelines/realtime/clock.h"
#include "tests/support/far_end.h"
#include "tests/support/ibus_checksum.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/app/log/log_in_memory.h"

/// What the log says of sensors that a receiver role asks at a pty.
namespace tribus::test::sensor_bus_log_test {
namespace {

using namespace std::chrono_literals;

/// Literal answers by command and address (docs/protocols/ibus.md, "Sensor bus: frames").
using Answers = std::map<unsigned, Bytes>;

Bytes frame(std::uint8_t command_and_address, const Bytes& data = {}) {
    Bytes bytes{static_cast<std::uint8_t>(4 + data.size()), command_and_address};
    bytes.insert(bytes.end(), data.begin(), data.end());
    return with_ibus_checksum(bytes);
}

class SensorBusLogAtAWire : public testing::Test {
  protected:
    SensorBusLogAtAWire() {
        auto started = Appliance::start(configuration());
        if (!started) {
            throw std::runtime_error(started.error().front());
        }
        appliance_ = std::move(*started);
        log_ = std::make_unique<SensorBusLog>(*appliance_, Instant(0s));
        while (!appliance_->bus_state(0).is_receiver) {  // nothing is published yet
            std::this_thread::sleep_for(1ms);
        }
    }

    /// Answers the requests until the log says this at a look at `now`.
    void expect_said(const std::string& line, const Answers& answers, Instant now = Instant(1s)) {
        const Instant patience = monotonic_now() + 10s;
        while (said().find(line + "\n") == std::string::npos) {
            ASSERT_LT(monotonic_now(), patience) << line << "\nwas not said, but\n" << said();
            answer(answers);
            log_->look(*appliance_, now);
            std::this_thread::sleep_for(1ms);
        }
    }
    std::string said() const { return logged_.text(); }
    void pull() {
        sensors_.pull();
        while (appliance_->port_present(0)) {
            appliance_->reopen_devices();
            std::this_thread::sleep_for(1ms);
        }
    }

    std::unique_ptr<Appliance> appliance_;
    std::unique_ptr<SensorBusLog> log_;

  private:
    void answer(const Answers& answers) {
        const Bytes arrived = sensors_.receive();
        requests_.insert(requests_.end(), arrived.begin(), arrived.end());
        constexpr std::size_t kRequest = 4;
        while (requests_.size() >= kRequest) {
            if (const auto found = answers.find(requests_[1]); found != answers.end()) {
                sensors_.send(found->second);
            }
            requests_.erase(requests_.begin(), requests_.begin() + kRequest);
        }
    }
    Configuration configuration() const {
        return load_configuration(
                   "[sensor_bus.probes]\nrole = \"receiver\"\nwires = \"two\"\n"
                   "power_up = false\ndevice = \"" +
                       sensors_.path() + "\"\n[runtime]\nrealtime = \"off\"\n",
                   "test.toml")
            .value();
    }

    TemporaryFolder folder_;
    FarEnd sensors_{folder_ / "sensors"};
    Bytes requests_;
    LogInMemory logged_{"%l %v"};
};

TEST_F(SensorBusLogAtAWire, NamesASensorThatIsFound) {
    expect_said("info sensor bus probes: address 1 is temperature",
                {{0x81, frame(0x81)}, {0x91, frame(0x91, {0x01, 2})}});
}

TEST_F(SensorBusLogAtAWire, SaysThatASensorNeverReportsItsTypeAndWhenItDoes) {
    expect_said(
        "warning sensor bus probes: a sensor at address 1 answers, but never reports its type; "
        "neither it nor a sensor at a higher address is read. Are there two sensors at this "
        "address, or is this no i.Bus sensor?",
        {{0x81, frame(0x81)}});
    expect_said("info sensor bus probes: address 1 is temperature",
                {{0x81, frame(0x81)}, {0x91, frame(0x91, {0x01, 2})}}, Instant(6s));
    EXPECT_EQ(said().find("no sensor replies"), std::string::npos) << said();
    EXPECT_EQ(said().find("no longer answers"), std::string::npos) << said();
}

TEST_F(SensorBusLogAtAWire, SaysThatASensorWithoutATypeIsGone) {
    expect_said(
        "warning sensor bus probes: a sensor at address 1 answers, but never reports its type; "
        "neither it nor a sensor at a higher address is read. Are there two sensors at this "
        "address, or is this no i.Bus sensor?",
        {{0x81, frame(0x81)}});
    expect_said("info sensor bus probes: address 1 no longer answers", {});
}

TEST_F(SensorBusLogAtAWire, SaysThatValuesHaveAnotherSizeThanTheSensorReported) {
    Answers answers{{0x81, frame(0x81)}, {0x91, frame(0x91, {0x01, 2})}};
    answers[0xA1] = frame(0xA1, {0x90, 0x01, 0, 0});
    expect_said(
        "warning sensor bus probes: the values of address 1 have 4 bytes, but the sensor reported "
        "2 "
        "with its type; they are not read",
        answers);
    EXPECT_EQ(said().find("is gone"), std::string::npos) << said();
    answers[0xA1] = frame(0xA1, {0x90, 0x01});
    expect_said(
        "info sensor bus probes: the values of address 1 have 2 bytes again, as it reported",
        answers);
}

TEST_F(SensorBusLogAtAWire, SaysThatATypeDoesNotHaveTheSizeThatTheSensorReports) {
    expect_said(
        "warning sensor bus probes: address 1 is temperature, but reports values of 3 "
        "bytes, where that type has 2; a [sensor_type] of your own with that id and size "
        "defines them",
        {{0x81, frame(0x81)}, {0x91, frame(0x91, {0x01, 3})}});
}

TEST_F(SensorBusLogAtAWire, SaysThatNoSensorRepliesAtAll) {
    expect_said(
        "warning sensor bus probes: no sensor replies yet; check wire, ground and power, and that "
        "TX and RX are joined if it is one wire",
        {}, Instant(3s));
}

TEST_F(SensorBusLogAtAWire, SaysNothingOfWiresWhileItsDeviceIsNotThere) {
    pull();
    log_->look(*appliance_, Instant(9s));
    EXPECT_EQ(said(), "");
}

}  // namespace
}  // namespace tribus::test::sensor_bus_log_test
