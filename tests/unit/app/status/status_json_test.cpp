#include "app/status/status_json.h"

#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include <gtest/gtest.h>

#include "config/load.h"

namespace tribus::status_json_test {
namespace {

using nlohmann::json;

constexpr std::string_view kConfig = R"([input.main]
protocol = "ibus"
device   = "/dev/ttyAMA5"
[input.backup]
protocol  = "can"
interface = "can0"
[output.servos]
protocol = "sbus"
device   = "/dev/ttyAMA3"
[pipeline.main]
from = ["main", "backup"]
to   = "servos"
[sensor_bus.probes]
device = "/dev/ttyAMA4"
role   = "receiver"
[gpio.stop]
line = "GPIO5"
role = "force_failsafe"
[gpio.lamp]
line = "GPIO17"
role = "link"
)";

const Instant kNow{std::chrono::seconds(100)};

class StatusJson : public testing::Test {
  protected:
    StatusJson() : configuration_(*load_configuration(std::string(kConfig), "/etc/car.toml")) {
        report_.configuration = &configuration_;
        report_.now = kNow;
        report_.wall_time = std::chrono::microseconds(1'700'000'000'000'001);
        report_.started = kNow - std::chrono::seconds(10);
        report_.figures_at = kNow - std::chrono::milliseconds(40);
        report_.inputs.resize(2);
        report_.inputs[0].reject_causes = {"checksum", "damaged"};
        report_.outputs.resize(1);
        report_.outputs[0].inputs = {0, 1};
        report_.ports = {{"/dev/ttyAMA5", true, {}},
                         {"can0", false, CanLinkStatus{CanBusState::bus_off, {}}},
                         {"/dev/ttyAMA3", true, {}}};
        report_.sensor_buses.resize(1);
        report_.sensor_buses[0].is_receiver = true;
        report_.lines = {{true, true}, {true, std::nullopt}};
    }
    json told() const { return json::parse(status_json(report_)); }
    InputStatus& input() { return report_.inputs[0].status; }
    OutputStatus& output() { return report_.outputs[0].status; }

    Configuration configuration_;
    StatusReport report_;
};

TEST_F(StatusJson, IsOneLine) {
    EXPECT_EQ(status_json(report_).find('\n'), std::string::npos);
}

TEST_F(StatusJson, SaysWhatEachLineIsForAndWhetherItIsActive) {
    EXPECT_EQ(told()["lines"], json::parse(R"([
        {"name":"stop","line":"GPIO5","present":true,"text":"is active","role":"force_failsafe",
         "active":true},
        {"name":"lamp","line":"GPIO17","present":true,"text":"is there","role":"link",
         "active":null}])"));
}

TEST_F(StatusJson, SaysWhoAndWhen) {
    const json status = told();
    EXPECT_EQ(status["type"], "status");
    EXPECT_EQ(status["version"], 1);
    EXPECT_EQ(status["name"], "car");
    EXPECT_EQ(status["file"], "/etc/car.toml");
    EXPECT_EQ(status["t_us"], 100'000'000);
    EXPECT_EQ(status["unix_time_us"], 1'700'000'000'000'001);
    EXPECT_EQ(status["uptime_us"], 10'000'000);
    EXPECT_EQ(status["figures_age_us"], 40'000);
}

TEST_F(StatusJson, SaysForHowLongAnOutputIsInItsState) {
    output().stage_since = kNow - std::chrono::milliseconds(120);
    EXPECT_EQ(told()["outputs"][0]["state_age_us"], 120'000);
}

TEST_F(StatusJson, NamesTheChannelsThatSendTheirPresets) {
    EXPECT_EQ(told()["outputs"][0]["by_preset"], json::array());
    output().state.by_preset = 1U << 4U | 1U << 17U;
    EXPECT_EQ(told()["outputs"][0]["by_preset"], json({5, 18}));
}

TEST_F(StatusJson, SaysWhatElseOnlyTheLogSaid) {
    EXPECT_EQ(told()["inputs"][0]["two_senders"], false);
    EXPECT_EQ(told()["absences"], 0);
    input().two_senders = true;
    report_.absence.count = 2;
    EXPECT_EQ(told()["inputs"][0]["two_senders"], true);
    EXPECT_EQ(told()["absences"], 2);
}

TEST_F(StatusJson, HasNoAgeOfFiguresThatNeverCame) {
    report_.figures_at = Instant{};
    EXPECT_TRUE(told()["figures_age_us"].is_null());
}

TEST_F(StatusJson, NamesTheCauseOfALostInputAndHowLongItIsSo) {
    input().state = {LinkCause::radio_lost, RadioLossSign::value_rule,
                     kNow - std::chrono::seconds(3)};
    const json main = told()["inputs"][0];
    EXPECT_EQ(main["name"], "main");
    EXPECT_EQ(main["protocol"], "ibus");
    EXPECT_EQ(main["port"], "/dev/ttyAMA5");
    EXPECT_EQ(main["state"], "failsafe");
    EXPECT_EQ(main["cause"], "radio_lost");
    EXPECT_EQ(main["sign"], "value_rule");
    EXPECT_EQ(main["state_age_us"], 3'000'000);
}

TEST_F(StatusJson, TellsAGoodInputFromOneWhoseFramesAreMarkedLost) {
    input().state.cause = LinkCause::good;
    input().latest.frame_lost = true;
    EXPECT_EQ(told()["inputs"][0]["state"], "frame_lost");
    input().latest.frame_lost = false;
    EXPECT_EQ(told()["inputs"][0]["state"], "good");
}

TEST_F(StatusJson, HasNoAgeOfAnInputThatWasNeverSeen) {
    const json main = told()["inputs"][0];
    EXPECT_EQ(main["cause"], "never_seen");
    EXPECT_TRUE(main["age_us"].is_null());
    EXPECT_TRUE(main["state_age_us"].is_null());
    EXPECT_EQ(main["channels"], json::array());
}

TEST_F(StatusJson, ChannelsAreMicrosecondsAndNullWhereAbsent) {
    input().latest.set(0, Pulse::from_microseconds(1500));
    input().latest.set(2, Pulse::from_fractional_microseconds(988.125));
    EXPECT_EQ(told()["inputs"][0]["channels"].dump(), "[1500,null,988.125]");
}

TEST_F(StatusJson, AgeOfAFrameCountsFromTheNewestOne) {
    input().counts.frames = 1;
    input().at = kNow - std::chrono::milliseconds(90);
    input().latest.received = input().at;
    input().newest_at = kNow - std::chrono::milliseconds(7);
    EXPECT_EQ(told()["inputs"][0]["age_us"], 7000);
    report_.now = kNow + std::chrono::seconds(5);
    EXPECT_EQ(told()["inputs"][0]["age_us"], 5'007'000);
}

TEST_F(StatusJson, CountsRejectsAndLossesByCause) {
    input().rejected_by = {3, 1};
    input().counts.began[static_cast<std::size_t>(LinkCause::wire_silent)] = 2;
    const json main = told()["inputs"][0];
    EXPECT_EQ(main["rejected"].dump(), R"({"checksum":3,"damaged":1})");
    EXPECT_EQ(main["losses"]["wire_silent"], 2);
}

TEST_F(StatusJson, NamesTheInputInControlAndThoseOutvoted) {
    output().state.stage = OutputStage::control;
    output().state.input = 1;
    output().state.outvoted = 1;
    const json servos = told()["outputs"][0];
    EXPECT_EQ(servos["state"], "control");
    EXPECT_EQ(servos["input"], "backup");
    EXPECT_EQ(servos["outvoted"].dump(), R"(["main"])");
    EXPECT_EQ(servos["inputs"].dump(), R"(["main","backup"])");
}

TEST_F(StatusJson, SaysWhatAnOutputWaitsFor) {
    output().wait = {.awaited = Awaited::run_time,
                     .input = 1,
                     .so_far = std::chrono::milliseconds(200),
                     .needed = std::chrono::milliseconds(500)};
    EXPECT_EQ(told()["outputs"][0]["waits_for"], "backup: good for 0.2 of 0.5 s");
    output().wait = {};
    EXPECT_TRUE(told()["outputs"][0]["waits_for"].is_null());
}

TEST_F(StatusJson, SaysWhyAnOutputIsNotInControl) {
    const auto why = [&] { return told()["outputs"][0]["why"]; };
    report_.inputs[1].status.state = {.cause = LinkCause::wire_silent,
                                      .since = kNow - std::chrono::seconds(192)};
    input().state = {.cause = LinkCause::good, .since = kNow};
    output().state.stage = OutputStage::control;
    EXPECT_EQ(why(), "backup: wire silent (no bytes any more) for 3 min 12 s");
    input().state = {.cause = LinkCause::radio_lost,
                     .sign = RadioLossSign::failsafe_flag,
                     .since = kNow - std::chrono::milliseconds(120)};
    output().state.stage = OutputStage::holding;
    output().stage_since = kNow - std::chrono::milliseconds(120);
    output().wait = {.awaited = Awaited::link, .input = 0, .link = input().state};
    const std::string awaited =
        "waits for main: radio lost (the receiver says failsafe) for 120 ms; ";
    const std::string other = "backup: wire silent (no bytes any more) for 3 min 12 s";
    EXPECT_EQ(why(), "failsafe in 180 ms; " + awaited + other);
    output().state.stage = OutputStage::failsafe;
    output().sends = true;
    EXPECT_EQ(why(), "it sends its presets; " + awaited + other);
    configuration_.pipelines[0].failsafe[0].action = FailsafeAction::hold;
    EXPECT_EQ(why(), "it sends the last values; " + awaited + other);
    output().sends = false;
    report_.inputs[1].status.state = {.cause = LinkCause::good};
    output().state.outvoted = 2;
    EXPECT_EQ(why(), "it sends nothing; " + awaited + "backup: outvoted by the others");
    output().state = {.stage = OutputStage::cannot_send, .obstacle = SendObstacle::device};
    EXPECT_EQ(why(),
              "waits for its device, which is gone; main: radio lost (the receiver says failsafe) "
              "for 120 ms");
}

TEST_F(StatusJson, SaysNothingOfAnOutputThatIsAsItShouldBe) {
    for (InputReport& one : report_.inputs) {
        one.status.state = {.cause = LinkCause::good, .since = kNow};
    }
    output().state.stage = OutputStage::control;
    EXPECT_TRUE(told()["outputs"][0]["why"].is_null());
}

TEST_F(StatusJson, TellsFailsafeThatIsSaidFromFailsafeThatIsSilence) {
    output().sends = true;
    EXPECT_EQ(told()["outputs"][0]["state"], "failsafe");
    EXPECT_TRUE(told()["outputs"][0]["input"].is_null());
    output().sends = false;
    EXPECT_EQ(told()["outputs"][0]["state"], "silent");
}

TEST_F(StatusJson, TellsWhichPortIsGoneAndTheStateOfABus) {
    const json ports = told()["ports"];
    EXPECT_EQ(ports[0].dump(),
              R"({"kind":"serial","name":"/dev/ttyAMA5","present":true,"text":"is there"})");
    EXPECT_EQ(ports[1]["present"], false);
    EXPECT_EQ(ports[1]["text"], "is gone; waiting for it");
    EXPECT_EQ(ports[1]["can"]["state"], "gone") << "whatever it was before";
    report_.ports[1].present = true;
    EXPECT_EQ(told()["ports"][1]["can"]["state"], "bus_off");
    EXPECT_EQ(told()["ports"][1]["text"],
              "bus-off: the controller left the bus after too many errors; check bit rate, "
              "termination and wiring");
}

TEST_F(StatusJson, AnOutputThatCannotSendSaysSoAndWhyAndNothingOfControl) {
    output().latest.frame_lost = false;
    output().latest.failsafe = false;
    output().state.stage = OutputStage::control;
    EXPECT_TRUE(told()["outputs"][0]["obstacle"].is_null());
    EXPECT_EQ(told()["outputs"][0]["failsafe"], false);
    output().state.stage = OutputStage::cannot_send;
    output().state.obstacle = SendObstacle::bus;
    output().sends = true;
    const json servos = told()["outputs"][0];
    EXPECT_EQ(servos["state"], "cannot_send");
    EXPECT_EQ(servos["obstacle"], "bus");
    EXPECT_EQ(servos["failsafe"], true);
    EXPECT_EQ(servos["frame_lost"], true);
    EXPECT_TRUE(servos["input"].is_null());
}

TEST_F(StatusJson, NamesTheSensorsThatWereFound) {
    report_.sensor_buses[0].found[0] = {.type = 0x03, .size = 2};
    report_.sensor_buses[0].found[1] = {.type = 0xEE, .size = 4};
    report_.sensor_buses[0].found_count = 2;
    const json found = told()["sensor_buses"][0]["found"];
    EXPECT_EQ(found[0].dump(), R"({"address":1,"bytes":2,"type":"external_voltage","type_id":3})");
    EXPECT_TRUE(found[1]["type"].is_null());
}

TEST_F(StatusJson, NamesSensorsThatAnswerAndCannotBeRead) {
    EXPECT_EQ(told()["sensor_buses"][0]["faults"], json::array());
    SensorFaults& faults = report_.sensor_buses[0].faults;
    faults[0] = {.kind = SensorFault::Kind::wrong_size, .sent_size = 4};
    faults[1] = {.kind = SensorFault::Kind::no_type};
    EXPECT_EQ(told()["sensor_buses"][0]["faults"].dump(),
              R"([{"address":1,"fault":"wrong_size","sent_bytes":4},)"
              R"({"address":2,"fault":"no_type","sent_bytes":null}])");
}

TEST_F(StatusJson, SaysWhatASensorBusDoesAndWaitsFor) {
    const auto text = [&] { return std::string(told()["sensor_buses"][0]["text"]); };
    SensorBusState& bus = report_.sensor_buses[0];
    EXPECT_EQ(text(), "waits for a sensor that answers");
    bus.found[0] = {.type = 0x03, .size = 2};
    bus.found[1] = {.type = 0xEE, .size = 4};
    bus.found_count = 2;
    bus.faults[1] = {.kind = SensorFault::Kind::wrong_size, .sent_size = 4};
    bus.faults[2] = {.kind = SensorFault::Kind::no_type};
    EXPECT_EQ(text(),
              "reads external voltage at address 1, unknown type ee at address 2; address 2 sends "
              "values of 4 bytes, another size than it reported; address 3 never reports its type");
    bus.is_receiver = false;
    EXPECT_EQ(text(), "waits for the first request of a receiver");
    bus.latest_request = kNow - std::chrono::milliseconds(999);
    EXPECT_EQ(text(), "a receiver sends requests; waiting for an address");
    bus.first_address = 1;
    EXPECT_EQ(text(), "answers the receiver");
    bus.latest_request = kNow - std::chrono::seconds(1);
    EXPECT_EQ(text(), "the receiver sends no more requests; waits for one");
}

TEST_F(StatusJson, AValueGrowsStaleAndKeepsItsNumber) {
    const NamedValue value{.name = "pack.voltage", .unit = "V", .lasts = std::chrono::seconds(1)};
    const Instant then = kNow - std::chrono::seconds(1);
    report_.values = {{value, {.number = 12.5, .at = then, .ever = true, .available = true}}};
    EXPECT_EQ(told()["values"][0].dump(),
              R"({"age_us":1000000,"name":"pack.voltage","number":12.5,"stale":false,)"
              R"("text":"12.5 V","unit":"V"})");
    report_.now += Duration(1);
    EXPECT_EQ(told()["values"][0]["stale"], true);
    EXPECT_EQ(told()["values"][0]["number"], 12.5);
    EXPECT_EQ(told()["values"][0]["text"], "stale: 12.5 V");
}

TEST_F(StatusJson, AValueThatIsNoNumberIsNull) {
    const NamedValue value{.name = "x", .unit = "", .lasts = kForever};
    report_.values = {{value, {}},
                      {value,
                       {.number = std::numeric_limits<double>::quiet_NaN(),
                        .at = kNow,
                        .ever = true,
                        .available = true}}};
    EXPECT_TRUE(told()["values"][0]["number"].is_null());
    EXPECT_EQ(told()["values"][0]["stale"], true);
    EXPECT_TRUE(told()["values"][1]["number"].is_null());
}

TEST_F(StatusJson, MachineFactsHaveTheirUnitInTheirName) {
    report_.machine = {48.5, 3.0, std::nullopt, std::nullopt, 0.0, 12.0};
    const json machine = told()["machine"];
    EXPECT_EQ(machine["temperature_degC"], 48.5);
    EXPECT_EQ(machine["load_percent"], 3);
    EXPECT_TRUE(machine["memory_percent"].is_null());
    EXPECT_EQ(machine["undervoltage"], 0);
    EXPECT_EQ(machine["uptime_s"], 12);
}

TEST_F(StatusJson, AFileNameOfAnyBytesIsStillJson) {
    configuration_.file = "/tmp/\xff\"\n.toml";
    EXPECT_TRUE(json::accept(status_json(report_)));
}

TEST(RateWindow, CountsByTheInstantsOfTheDataThread) {
    RateWindow window;
    const Instant start{std::chrono::seconds(5)};
    for (int i = 0; i <= 10; ++i) {
        window.look(static_cast<std::uint64_t>(i) * 10, start + i * std::chrono::milliseconds(100));
    }
    EXPECT_DOUBLE_EQ(window.rate_hz(start + std::chrono::seconds(1)), 100);
}

TEST(RateWindow, HasNoRateOfADataThreadThatStandsStill) {
    RateWindow window;
    const Instant start{std::chrono::seconds(5)};
    window.look(0, start);
    window.look(100, start + std::chrono::seconds(1));
    EXPECT_DOUBLE_EQ(window.rate_hz(start + std::chrono::seconds(2)), 100);
    EXPECT_DOUBLE_EQ(window.rate_hz(start + std::chrono::milliseconds(2001)), 0);
}

}  // namespace
}  // namespace tribus::status_json_test
