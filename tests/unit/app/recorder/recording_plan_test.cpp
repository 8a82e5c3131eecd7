#include "app/recorder/recording_plan.h"

#include <algorithm>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "config/load.h"

namespace tribus::test::recording_plan_test {
namespace {

using Files = std::pair<std::string, std::string>;

/// Names of the files for what is read from /dev/a and what is written to it.
Files files_of_a(const std::string& text) {
    const auto configuration = load_configuration(text, "test.toml");
    if (!configuration) {
        return {configuration.error().front().text, {}};
    }
    const RecordingPlan plan = plan_recording(*configuration, plan_ports(*configuration), {});
    const auto port = std::ranges::find(plan.ports, "/dev/a", &RecordedPort::device);
    return port == plan.ports.end() ? Files() : Files(port->read_file, port->written_file);
}

TEST(RecordingPlan, NamesFilesOfAnInputAndOfAnOutputOnOnePort) {
    EXPECT_EQ(files_of_a("[input.receiver]\nprotocol = \"crsf\"\ndevice = \"/dev/a\"\n"
                         "[output.servos]\nprotocol = \"crsf\"\ndevice = \"/dev/a\"\n"
                         "[pipeline.main]\nfrom = [\"receiver\"]\nto = [\"servos\"]\n"),
              Files("input-receiver.txt", "output-servos.txt"));
}

TEST(RecordingPlan, NamesTheFileOfWhatATransmitterModuleSends) {
    EXPECT_EQ(files_of_a("[output.module]\nprotocol = \"crsf\"\nrole = \"handset\"\n"
                         "baud = 400000\ndevice = \"/dev/a\"\n"
                         "[input.stick]\nprotocol = \"ibus\"\ndevice = \"/dev/b\"\n"
                         "[pipeline.main]\nfrom = [\"stick\"]\nto = [\"module\"]\n"),
              Files("output-module-heard.txt", "output-module.txt"));
}

TEST(RecordingPlan, NamesTheFileOfValuesFromBytes) {
    EXPECT_EQ(files_of_a("[values.model]\nprotocol = \"crsf-telemetry\"\n"
                         "device = \"/dev/a\"\n"
                         "[sensor_bus.t]\ndevice = \"/dev/d\"\nrole = \"sensor\"\n"
                         "sensor = [{ type = \"battery_current\", "
                         "value = \"model.battery.current\" }]\n"
                         "[input.stick]\nprotocol = \"ibus\"\ndevice = \"/dev/b\"\n"
                         "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/c\"\n"
                         "[pipeline.main]\nfrom = [\"stick\"]\nto = [\"servos\"]\n"),
              Files("values-model.txt", ""));
}

}  // namespace
}  // namespace tribus::test::recording_plan_test
