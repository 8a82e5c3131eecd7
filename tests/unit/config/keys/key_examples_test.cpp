#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "config/keys/words.h"
#include "config/show/manual_sections.h"
#include "tests/support/dbc_maps.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/config/main_job.h"
#include "transports/registry/registry.h"

/// The example of every key in the manual, in a whole configuration that must be valid with it.
namespace tribus::test::key_examples_test {
namespace {

using Lines = std::vector<std::string>;

/// Marks the place of the example in a configuration.
constexpr std::string_view kHere = "HERE";

const std::string kMessages = R"(BO_ 256 Command: 8 A
 SG_ Steering : 0|8@1+ (1,0) [0|250] "" B
 SG_ LeftStatus : 8|2@1+ (1,0) [0|1] "" B
 SG_ RightStatus : 10|2@1+ (1,0) [0|1] "" B
 SG_ NeutralStatus : 12|2@1+ (1,0) [0|1] "" B
 SG_ Lost : 14|1@1+ (1,0) [0|1] "" B
 SG_ Speed : 16|16@1- (0.001,0) [-1.5|1.5] "m/s" B
 SG_ Count : 32|4@1+ (1,0) [0|15] "" B
 SG_ Mode : 36|4@1+ (1,0) [0|15] "" B
 SG_ Check : 56|8@1+ (1,0) [0|255] "" B
BO_ 257 Heartbeat: 1 A
 SG_ State : 0|8@1+ (1,0) [0|255] "" B
BO_ 512 Battery: 2 A
 SG_ Voltage : 0|16@1+ (0.001,0) [0|60] "V" B
BO_ 2566772478 Joystick: 8 A
 SG_ X : 0|8@1+ (1,0) [0|250] "" B
)" + j1939_frames({2566772478});

constexpr std::string_view kTwoInputs = R"([input.main]
protocol = "sbus"
device = "/dev/ttyA"
[input.backup]
protocol = "sbus"
device = "/dev/ttyC"
)";
constexpr std::string_view kBattery = R"([values.battery]
interface = "can0"
dbc = "telemetry.dbc"
message = "Battery"
signals = { voltage = "Voltage" }
)";

std::string around(std::string_view table) {
    return std::string(table) + std::string(kReceiverTable) + std::string(kServosTable) +
           std::string(kPipelineTable);
}
std::string input(std::string_view lines) {
    return "[input.receiver]\n" + std::string(lines) + "HERE\n" + std::string(kServosTable) +
           std::string(kPipelineTable);
}
std::string output(std::string_view lines) {
    return "[output.servos]\n" + std::string(lines) + "HERE\n" + std::string(kReceiverTable) +
           std::string(kPipelineTable);
}
std::string on_two_inputs(std::string_view pipeline) {
    return std::string(kTwoInputs) + std::string(kServosTable) + std::string(pipeline);
}
std::string bus_sensor(std::string_view lines) {
    return "[values.battery]\nconstant = 12\n[sensor_bus.t]\ndevice = \"/dev/ttyD\"\n"
           "role = \"sensor\"\n" +
           std::string(lines);
}
std::string battery_in_values(std::string_view lines) {
    return "[values.battery]\n" + std::string(lines) + "HERE\n" + std::string(kReceiverTable) +
           std::string(kServosTable) + std::string(kPipelineTable);
}
std::string line(std::string_view lines) {
    return "[gpio.record]\nline = \"GPIO17\"\n" + std::string(lines) + "HERE\n" +
           on_two_inputs("[pipeline.main]\nfrom = [\"main\", \"backup\"]\nto = \"servos\"\n");
}
std::string on_dronecan(std::string_view way, std::string_view lines) {
    const std::string port = "[" + std::string(way) +
                             "]\nprotocol = \"dronecan\"\ninterface = \"can0\"\n" +
                             std::string(lines) + "HERE\n";
    return port + std::string(way == "input.receiver" ? kServosTable : kReceiverTable) +
           std::string(kPipelineTable);
}
std::string signal(std::string_view name, std::string_view lines) {
    return "[output.servos]\nprotocol = \"dbc\"\ninterface = \"can0\"\ndbc = \"rover.dbc\"\n"
           "[output.servos.signals.Command]\nMode = { channel = 5 }\n"
           "[output.servos.signals.Command." +
           std::string(name) + "]\n" + std::string(lines) + "HERE\n" + std::string(kBattery) +
           std::string(kReceiverTable) + std::string(kPipelineTable);
}

std::string telemetry(std::string_view lines) {
    return around(
        "[sensor_bus.probes]\ndevice = \"/dev/ttyD\"\nrole = \"receiver\"\n"
        "[output.handset]\nprotocol = \"crsf-telemetry\"\ndevice = \"/dev/ttyT\"\n" +
        std::string(lines) + "HERE\n");
}

std::string exbus_telemetry(std::string_view lines) {
    return around(
        "[sensor_bus.probes]\ndevice = \"/dev/ttyD\"\nrole = \"receiver\"\n"
        "[output.display]\nprotocol = \"exbus-telemetry\"\ndevice = \"/dev/ttyT\"\n" +
        std::string(lines));
}

std::string protocol_line(const Protocol& protocol) {
    return "protocol = \"" + std::string(protocol.name) + "\"\n";
}
std::string place_line(const Medium& medium, SettingScope way) {
    const bool other = way == SettingScope::output && !medium.place.output_example.empty();
    return std::string(medium.place.key) + " = " +
           std::string(other ? medium.place.output_example : medium.place.example) + "\n";
}

/// For all keys of a section, by its anchor.
std::map<std::string, std::string> contexts() {
    const std::string serial = "protocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n";
    return {
        {"runtime", around("[runtime]\nHERE\n")},
        {"input", input(serial)},
        {"failsafe_when",
         input(serial + "[[input.receiver.failsafe_when]]\nchannel = 3\nbelow = 950\n")},
        {"output", output(serial)},
        {"dbc", input("protocol = \"dbc\"\ninterface = \"can0\"\ndbc = \"rover.dbc\"\n"
                      "signals = { Command = { Steering = 1 }, Heartbeat = { State = { fixed = 5 } "
                      "} }\n")},
        {"dbc-signals", signal("Steering", "channel = 1\n")},
        {"sensors",
         "[output.servos]\nprotocol = \"sensors\"\ninterface = \"can0\"\n"
         "sensor_bus = \"probes\"\nHERE\n[sensor_bus.probes]\ndevice = \"/dev/ttyD\"\n"
         "role = \"receiver\"\n"},
        {"dronecan", on_dronecan("output.servos", "node_id = 42\n")},
        {"pwm", output("protocol = \"pwm\"\nchip = \"pwmchip0\"\noutputs = { 1 = 0 }\n")},
        {"crsf-telemetry", telemetry("vario = \"probes.1\"\n")},
        {"crsf-telemetry-battery", telemetry("[output.handset.battery]\n")},
        {"crsf-telemetry-gps", telemetry("[output.handset.gps]\nlatitude = \"probes.1\"\n"
                                         "longitude = \"probes.2\"\n")},
        {"crsf-telemetry-attitude", telemetry("[output.handset.attitude]\n")},
        {"crsf-telemetry-flight_mode",
         telemetry("[output.handset.flight_mode]\nvalue = \"probes.1\"\nnames = [\"A\"]\n")},
        {"exbus-telemetry", exbus_telemetry("sensors = { 1 = { value = \"probes.1\" } }\nHERE\n")},
        {"exbus-telemetry-sensors",
         exbus_telemetry("[output.display.sensors.1]\nvalue = \"probes.5\"\nHERE\n")},
        {"pipeline", on_two_inputs("[pipeline.main]\nfrom = [\"main\", \"backup\"]\n"
                                   "to = \"servos\"\nHERE\n")},
        {"handover", on_two_inputs("[pipeline.main]\nfrom = [\"main\", \"backup\"]\n"
                                   "to = \"servos\"\n[pipeline.main.handover]\ninput = \"main\"\n"
                                   "channel = 8\nHERE\n")},
        {"channels", around("[pipeline.main.channels.1]\nfrom = 1\nHERE\n")},
        {"failsafe",
         "[pipeline.main]\nfrom = \"receiver\"\nto = [\"servos\", \"bus\"]\n"
         "[pipeline.main.failsafe]\nHERE\n" +
             std::string(kReceiverTable) + std::string(kServosTable) +
             "[output.bus]\nprotocol = \"can\"\ninterface = \"can0\"\n"},
        {"release_when", around("[pipeline.main.failsafe.release_when]\nchannel = 3\n"
                                "below = 1050\nHERE\n")},
        {"gpio", line("role = \"link\"\n")},
        {"sensor_bus", bus_sensor("HERE\n[[sensor_bus.t.sensor]]\ntype = \"fuel\"\n"
                                  "value = \"battery\"\n")},
        {"sensor", std::string(kBattery) +
                       "[sensor_bus.t]\ndevice = \"/dev/ttyD\"\nrole = \"sensor\"\n"
                       "[[sensor_bus.t.sensor]]\ntype = \"fuel\"\nvalue = \"battery.voltage\"\n"
                       "HERE\n"},
        {"sensor_type", around("[sensor_type.lidar]\nid = 81\nHERE\n")},
        {"values", battery_in_values("interface = \"can0\"\ndbc = \"telemetry.dbc\"\n"
                                     "message = \"Battery\"\n")},
        {"dronecan_node", around("[dronecan.bus]\ninterface = \"can0\"\nnode_id = 7\nHERE\n")},
        {"recorder", around("[recorder]\nHERE\n")},
    };
}

std::string default_context(const Protocol& protocol, bool of_output) {
    const auto lines = [&protocol](SettingScope way) {
        return protocol_line(protocol) + place_line(*media_for(protocol).front(), way);
    };
    return of_output ? output(lines(SettingScope::output)) : input(lines(SettingScope::input));
}

/// For keys that go with others than the rest of their section.
std::map<std::string, std::string> special_contexts() {
    const std::string receiver = "[sensor_bus.t]\ndevice = \"/dev/ttyD\"\nrole = \"receiver\"\n";
    const std::string dronecan_values = battery_in_values(
        "interface = \"can0\"\n"
        "dronecan = \"uavcan.equipment.power.BatteryInfo\"\n");
    const std::string telemetry_of_a_controller = "protocol = \"crsf-telemetry\"\n";
    const std::string module_line = "protocol = \"crsf\"\ndevice = \"/dev/ttyB\"\nbaud = 400000\n";
    const std::string to_autopilot =
        "protocol = \"mavlink\"\ndevice = \"/dev/ttyB\"\nmessage = \"rc_channels_override\"\n";
    const std::string by_network = "protocol = \"network\"\naddress = \"127.0.0.1:5501\"\n";
    const std::string by_can_fd = "protocol = \"can\"\ninterface = \"can0\"\nfd = true\n";
    const std::string on_can = output("protocol = \"can\"\ninterface = \"can0\"\n");
    std::map<std::string, std::string> contexts{
        {"failsafe_when-all_zero",
         input("protocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n[[input.receiver.failsafe_when]]\n")},
        {"output-phase", output("protocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                                "schedule = \"grid\"\n")},
        {"output-foreign_sender", on_can},
        {"dbc-own_address", output("protocol = \"dbc\"\ninterface = \"can0\"\ndbc = \"rover.dbc\"\n"
                                   "signals = { Joystick = { X = 1 } }\n")},
        {"dronecan-from_node", on_dronecan("input.receiver", "")},
        {"dronecan-first", on_dronecan("output.servos", "node_id = 42\ncarries = \"servos\"\n")},
        {"dronecan-scale", on_dronecan("input.receiver", "")},
        {"dronecan-safety", on_dronecan("input.receiver", "carries = \"servos\"\n")},
        {"dronecan-command", on_dronecan("output.servos", "node_id = 42\ncarries = \"servos\"\n")},
        {"dronecan-reversible",
         on_dronecan("output.servos", "node_id = 42\ncarries = \"motors\"\n")},
        {"dronecan-arms", on_dronecan("output.servos", "node_id = 42\ncarries = \"motors\"\n")},
        {"pipeline-tolerance",
         on_two_inputs("[input.third]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyE\"\n"
                       "[pipeline.main]\nfrom = [\"main\", \"backup\", \"third\"]\n"
                       "to = \"servos\"\nmode = \"median\"\nHERE\n")},
        {"channels-mix", around("[pipeline.main.channels.1]\nHERE\n")},
        {"channels-fixed", around("[pipeline.main.channels.1]\nHERE\n")},
        {"channels-line", around("[gpio.record]\nline = \"GPIO5\"\nrole = \"button\"\n"
                                 "[pipeline.main.channels.1]\nHERE\n")},
        {"gpio-bias", line("role = \"force_failsafe\"\n")},
        {"gpio-debounce", line("role = \"force_failsafe\"\n")},
        {"gpio-input", line("role = \"select\"\n")},
        {"gpio-period", line("role = \"fresh\"\n")},
        {"gpio-channel", line("role = \"switch\"\noutput = \"servos\"\nabove = 1700\n")},
        {"gpio-below", line("role = \"switch\"\noutput = \"servos\"\nchannel = 9\nabove = 1700\n")},
        {"gpio-above", line("role = \"switch\"\noutput = \"servos\"\nchannel = 9\n")},
        {"gpio-between", line("role = \"switch\"\noutput = \"servos\"\nchannel = 9\n")},
        {"sensor_bus-sensor",
         std::string(kBattery) +
             "[sensor_bus.t]\ndevice = \"/dev/ttyD\"\nrole = \"sensor\"\nHERE\n"},
        {"sensor_bus-slot", receiver + "HERE\n"},
        {"sensor_bus-power_up", receiver + "HERE\n"},
        {"sensor_bus-probe_every", receiver + "HERE\n"},
        {"sensor_bus-drop_after", receiver + "HERE\n"},
        {"sensor_bus-timeout", receiver + "HERE\n"},
        {"sensor-values",
         "[values.gps]\ninterface = \"can0\"\ndronecan = \"uavcan.equipment.gnss.Fix2\"\n"
         "[sensor_bus.t]\ndevice = \"/dev/ttyD\"\nrole = \"sensor\"\n"
         "[[sensor_bus.t.sensor]]\ntype = \"gps_status\"\nHERE\n"},
        {"values-constant", battery_in_values("")},
        {"values-unit", battery_in_values("constant = 6\n")},
        {"values-dronecan", battery_in_values("interface = \"can0\"\n")},
        {"values-node", dronecan_values},
        {"values-instance", dronecan_values},
        {"values-fd", dronecan_values},
        {"values-protocol", battery_in_values("device = \"/dev/ttyD\"\n")},
        {"values-device", battery_in_values(telemetry_of_a_controller)},
        {"values-address", battery_in_values(telemetry_of_a_controller)},
        {"values-public",
         battery_in_values(telemetry_of_a_controller + "address = \"127.0.0.1:5502\"\n")},
        {"values-sender",
         battery_in_values(telemetry_of_a_controller + "address = \"127.0.0.1:5502\"\n")},
        {"values-key", battery_in_values("protocol = \"mavlink-telemetry\"\n"
                                         "device = \"/dev/ttyD\"\n")},
        {"network-old_key", input(by_network + "key = \"drone.key\"\n")},
        {"network-link", input(by_network + "key = \"drone.key\"\n")},
        {"network-epoch", input(by_network + "key = \"drone.key\"\n")},
        {"can-key", input(by_can_fd)},
        {"can-old_key", input(by_can_fd + "key = \"drone.key\"\n")},
        {"can-link", input(by_can_fd + "key = \"drone.key\"\n")},
        {"can-epoch", input(by_can_fd + "key = \"drone.key\"\n")},
        {"mavlink-link_id", output(to_autopilot + "key = \"drone.key\"\n")},
        {"values-baud", battery_in_values(telemetry_of_a_controller + "device = \"/dev/ttyD\"\n")},
        {"crsf-role", output(module_line)},
        {"output-output_enable", output("protocol = \"pwm\"\nchip = \"pwmchip0\"\n"
                                        "outputs = { 1 = 0 }\n")},
        {"output-chip", output("protocol = \"pwm\"\noutputs = { 1 = 0 }\n")},
        {"mavlink-buttons", input("protocol = \"mavlink\"\ndevice = \"/dev/ttyA\"\n"
                                  "message = \"manual_control\"\n")},
        {"mavlink-throttle", input("protocol = \"mavlink\"\ndevice = \"/dev/ttyA\"\n"
                                   "message = \"manual_control\"\n")},
        {"mavlink-on_loss", output(to_autopilot)},
        {"mavlink-version", output(to_autopilot)},
        {"crsf-model_id", output(module_line + "role = \"handset\"\n")},
        {"dbc-signals-channel", signal("Speed", "")},
        {"dbc-signals-value", signal("Speed", "channel = 1\n")},
        {"dbc-signals-positive", signal("Steering", "channel = 1\nnegative = \"LeftStatus\"\n")},
        {"dbc-signals-neutral", signal("Steering", "channel = 1\nnegative = \"LeftStatus\"\n")},
        {"dbc-signals-flag", signal("Lost", "")},
        {"dbc-signals-fixed", signal("Steering", "")},
        {"dbc-signals-counter", signal("Count", "")},
        {"dbc-signals-most", signal("Count", "counter = true\n")},
        {"dbc-signals-checksum", signal("Check", "")},
        {"dbc-signals-data_id", signal("Steering", "checksum = \"p01\"\n")},
        {"dbc-signals-from", signal("Count", "")},
    };
    for (const Medium* medium : media()) {
        const auto carried = std::ranges::find_if(
            protocols(), [medium](const Protocol* one) { return carries(*medium, *one); });
        const std::string protocol = protocol_line(**carried);
        contexts.emplace("input-" + std::string(medium->place.key), input(protocol));
        contexts.emplace("output-" + std::string(medium->place.key), output(protocol));
        for (const Setting& setting : medium->settings) {
            contexts.emplace("input-" + std::string(setting.key),
                             input(protocol + place_line(*medium, SettingScope::input)));
            contexts.emplace("output-" + std::string(setting.key),
                             output(protocol + place_line(*medium, SettingScope::output)));
        }
    }
    return contexts;
}

Lines split(const std::string& text) {
    std::istringstream stream(text);
    Lines lines;
    for (std::string line; std::getline(stream, line);) {
        lines.push_back(line);
    }
    return lines;
}

/// The example in its context. It takes the place of an earlier line of the same table and key.
std::string with_example(const std::string& context, std::string_view key,
                         const std::string& example) {
    Lines lines = split(context);
    auto here = std::ranges::find(lines, kHere);
    EXPECT_NE(here, lines.end()) << context;
    *here = example;
    for (auto earlier = here; earlier != lines.begin() && !earlier->starts_with("[");) {
        --earlier;
        if (earlier->starts_with(std::string(key) + " =")) {
            earlier->clear();
        }
    }
    std::string text;
    for (const std::string& line : lines) {
        text += line + "\n";
    }
    return text;
}

TEST(KeyExamples, AreValidForEveryKey) {
    const test::TemporaryFolder folder;
    folder.write("rover.dbc", kMessages);
    folder.write("telemetry.dbc", kMessages);
    std::filesystem::permissions(folder.write("drone.key", std::string(64, '7')),
                                 std::filesystem::perms::owner_read);
    const auto general = contexts();
    const auto special = special_contexts();
    std::size_t count = 0;
    for (const ManualSection& section : manual_sections()) {
        for (const Key& key : section.keys) {
            const std::string name = section.anchor + "-" + std::string(key.name());
            ASSERT_FALSE(key.setting.example.empty()) << name << " has no example";
            const auto own = special.find(name);
            const auto shared = general.find(section.anchor);
            const Protocol* const protocol = find_protocol(section.anchor);
            ASSERT_TRUE(own != special.end() || shared != general.end() || protocol != nullptr)
                << name;
            const std::string context =
                own != special.end() ? own->second
                : shared != general.end()
                    ? shared->second
                    : default_context(*protocol, key.setting.scope == SettingScope::output);
            const std::string text = with_example(context, key.name(),
                                                  key.setting.type == SettingType::key_file
                                                      ? std::string(key.name()) + " = \"drone.key\""
                                                      : words_of(key, section.way).example);
            EXPECT_EQ(mistakes_in(text, folder / "t.toml"), Lines{}) << name << "\n" << text;
            ++count;
        }
    }
    EXPECT_GT(count, 150U);
}

}  // namespace
}  // namespace tribus::test::key_examples_test
