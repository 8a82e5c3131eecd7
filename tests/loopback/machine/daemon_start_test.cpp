#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/machine/running_daemon.h"

/// The start of a daemon, its looks and its end.
namespace tribus::test::daemon_start_test {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

class DaemonStart : public RunningDaemon {};

TEST_F(DaemonStart, SaysWhatItRuns) {
    EXPECT_FALSE(daemon_->runs());
    start();
    EXPECT_TRUE(daemon_->runs());
    EXPECT_EQ(said("started"), "started " + file_ + ": 1 input, 1 output, 1 pipeline\n");
    EXPECT_EQ(manager_.told(), Lines{"READY=1"});
}

TEST_F(DaemonStart, CountsSensorBuses) {
    const FarEnd sensors(folder_ / "sensors");
    start(job("servos", "[sensor_bus.telemetry]\nrole = \"sensor\"\nwires = \"two\"\ndevice = \"" +
                            sensors.path() +
                            "\"\n[[sensor_bus.telemetry.sensor]]\ntype = \"external_voltage\"\n"
                            "value = \"cells\"\n[values.cells]\nconstant = 1\nunit = \"V\"\n"));
    EXPECT_EQ(said("started"),
              "started " + file_ + ": 1 input, 1 output, 1 pipeline, 1 sensor bus\n");
}

TEST_F(DaemonStart, WaitsForADeviceThatIsAbsent) {
    servos_.pull();
    start();
    EXPECT_TRUE(daemon_->runs());
    EXPECT_TRUE(has_said("; waiting for it\nstarted ")) << logged_.text();
}

TEST_F(DaemonStart, FailsWhereADeviceThatIsThereCannotBeOpened) {
    servos_.pull();
    std::filesystem::create_symlink(receiver_.path(), servos_.path());
    start();
    EXPECT_FALSE(daemon_->runs());
    EXPECT_TRUE(has_said("another program uses it")) << logged_.text();
    EXPECT_EQ(said("started"), "");
    EXPECT_EQ(manager_.told(), Lines{});
}

TEST_F(DaemonStart, SaysWhatItLacksForRealTime) {
    Configuration configuration = load_configuration_file(file_).value();
    configuration.runtime.cpu = 1000;
    daemon_->start(std::move(configuration));
    EXPECT_TRUE(daemon_->runs());
    EXPECT_NE(said("no full real time: "), "");
}

TEST_F(DaemonStart, OpensWhatIsPluggedInLater) {
    servos_.pull();
    start();
    servos_.plug_in();
    daemon_->look(monotonic_now());
    EXPECT_TRUE(has_said("device " + servos_.path() + ": is there")) << logged_.text();
}

TEST_F(DaemonStart, TellsTheServiceManagerHowItGoes) {
    start();
    daemon_->look(monotonic_now());
    EXPECT_EQ(manager_.told_without_times(),
              (Lines{"READY=1", "STATUS=servos: in failsafe; receiver: never seen"}));
}

TEST_F(DaemonStart, ReadsTheMachineOnlyWhileSomebodyLooks) {
    start();
    daemon_->look(monotonic_now());
    const auto load = [&](Guest& guest) {
        guest.say("status\n");
        return nlohmann::json::parse(answer_to(guest))["machine"].dump();
    };
    Guest guest(folder_ / "control");
    const std::string before = load(guest);
    daemon_->look(monotonic_now());
    EXPECT_NE(load(guest), before);
}

TEST_F(DaemonStart, CountsFramesASecond) {
    start();
    EXPECT_TRUE(seen_within([&] {
        daemon_->look(monotonic_now());
        return nlohmann::json::parse(answer("status"))["outputs"][0]["rate_hz"] > 0;
    }));
}

TEST_F(DaemonStart, RecordsALoss) {
    const auto recordings = folder_.path() / "recordings";
    std::string text =
        job("servos", "[recorder]\nmemory = 65536\ndirectory = \"" + recordings.string() + "\"\n");
    text.replace(text.find("10s"), 3, "1s");
    start(text);
    ASSERT_TRUE(says_under_frames("under control of receiver"));
    receiver_.pull();
    const auto is_recorded = [&] {
        return std::filesystem::exists(recordings) && !std::filesystem::is_empty(recordings);
    };
    EXPECT_TRUE(seen_within([&] {
        daemon_->look(monotonic_now());
        return is_recorded();
    })) << logged_.text();
}

TEST_F(DaemonStart, AtItsEndSendsNoMoreFramesAndSaysSo) {
    start();
    manager_.told();
    daemon_->end();
    EXPECT_EQ(said("stopped"), "stopped\n");
    EXPECT_EQ(manager_.told(),
              Lines{"STOPPING=1\nSTATUS=outputs send their last frames as their failsafe demands"});
    // A worker of the kernel hands on what a pty has.
    EXPECT_TRUE(seen_within(
        [&] {
            servos_.receive();
            std::this_thread::sleep_for(100ms);
            return servos_.receive().empty();
        },
        5s));
}

}  // namespace
}  // namespace tribus::test::daemon_start_test
