#include "app/log/sensor_bus_log.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "config/load.h"
#include "pipelines/realtime/clock.h"
#include "tests/support/far_end.h"
#include "tests/support/ibus_checksum.h"
#include "tests/support/log_in_memory.h"
#include "tests/support/temporary_folder.h"

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

    /// Answers the requests until the log says this at a look at `now`. Returns false if it says
    /// too that the sensor is gone: a busy machine answers too late.
    bool says(const std::string& line, const Answers& answers, Instant now) {
        const Instant patience = monotonic_now() + 30s;
        const std::size_t before = said().size();
        const auto has = [&](const std::string& text) {
            return said().find(text, before) != std::string::npos;
        };
        const auto is_gone = [&] { return has("is gone") || has("no longer answers"); };
        while (!has(line + "\n") && !is_gone()) {
            if (monotonic_now() > patience) {
                ADD_FAILURE() << line << "\nwas not said, but\n" << said();
                return true;
            }
            answer(answers);
            log_->look(*appliance_, now);
            std::this_thread::sleep_for(1ms);
        }
        return !is_gone();
    }
    /// The same of lines, one after the other, each with its answers. Begins anew if the sensor is
    /// gone in between.
    struct Said {
        std::string line;
        Answers answers;
    };
    void expect_said(const std::vector<Said>& lines) {
        for (int minute = 0; minute < 10; ++minute) {
            const Instant now = Instant(1s) + std::chrono::minutes(minute);
            if (std::ranges::all_of(
                    lines, [&](const Said& one) { return says(one.line, one.answers, now); })) {
                return;
            }
        }
        ADD_FAILURE() << "the sensor was gone again and again\n" << said();
    }
    void expect_said(const std::string& line, const Answers& answers) {
        expect_said({{line, answers}});
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

const std::string kNoType =
    "warning sensor bus probes: a sensor at address 1 answers, but never reports its type; "
    "neither it nor a sensor at a higher address is read. Are there two sensors at this address, "
    "or is this no i.Bus sensor?";

TEST_F(SensorBusLogAtAWire, SaysThatASensorNeverReportsItsTypeAndWhenItDoes) {
    expect_said({{kNoType, {{0x81, frame(0x81)}}},
                 {"info sensor bus probes: address 1 is temperature",
                  {{0x81, frame(0x81)}, {0x91, frame(0x91, {0x01, 2})}}}});
    EXPECT_EQ(said().find("no sensor replies"), std::string::npos) << said();
}

TEST_F(SensorBusLogAtAWire, SaysThatASensorWithoutATypeIsGone) {
    expect_said(kNoType, {{0x81, frame(0x81)}});
    EXPECT_FALSE(says("nothing else", {}, Instant(1s)));
    EXPECT_NE(said().find("info sensor bus probes: address 1 no longer answers\n"),
              std::string::npos)
        << said();
}

TEST_F(SensorBusLogAtAWire, SaysThatValuesHaveAnotherSizeThanTheSensorReported) {
    Answers wrong{{0x81, frame(0x81)}, {0x91, frame(0x91, {0x01, 2})}};
    Answers right = wrong;
    wrong[0xA1] = frame(0xA1, {0x90, 0x01, 0, 0});
    right[0xA1] = frame(0xA1, {0x90, 0x01});
    expect_said({{"warning sensor bus probes: the values of address 1 have 4 bytes, but the sensor "
                  "reported 2 with its type; they are not read",
                  wrong},
                 {"info sensor bus probes: the values of address 1 have 2 bytes again, as it "
                  "reported",
                  right}});
}

TEST_F(SensorBusLogAtAWire, SaysThatATypeDoesNotHaveTheSizeThatTheSensorReports) {
    expect_said(
        "warning sensor bus probes: address 1 is temperature, but reports values of 3 "
        "bytes, where that type has 2; a [sensor_type] of your own with that id and size "
        "defines them",
        {{0x81, frame(0x81)}, {0x91, frame(0x91, {0x01, 3})}});
}

TEST_F(SensorBusLogAtAWire, SaysThatNoSensorRepliesAtAll) {
    log_->look(*appliance_, Instant(2900ms));
    EXPECT_EQ(said(), "");
    log_->look(*appliance_, Instant(3s));
    EXPECT_EQ(said(),
              "warning sensor bus probes: no sensor replies yet; check wire, ground and power, and "
              "that TX and RX are joined if it is one wire\n");
}

TEST_F(SensorBusLogAtAWire, SaysNothingOfWiresWhileItsDeviceIsNotThere) {
    pull();
    log_->look(*appliance_, Instant(9s));
    EXPECT_EQ(said(), "");
}

}  // namespace
}  // namespace tribus::test::sensor_bus_log_test
