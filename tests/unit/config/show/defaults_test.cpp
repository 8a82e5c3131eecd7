#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "config/keys/keys.h"
#include "config/read/line.h"
#include "config/read/supervision.h"
#include "config/read/values.h"
#include "config/schema/choices.h"
#include "config/show/effective.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/config/main_job.h"
#include "transports/registry/registry.h"

/// `tribus check` prints every default, and accepts what it prints.
namespace tribus::test::defaults_test {
namespace {

using Json = nlohmann::json;
using Applies = std::function<bool(std::string_view key)>;

bool to_all(std::string_view /*key*/) {
    return true;
}

/// What `check` prints. Accepts it and prints it again, which must give the same.
Json printed(const std::string& text, const std::string& file = "t.toml") {
    const auto configuration = load_configuration(text, file);
    if (!configuration) {
        ADD_FAILURE() << format_mistake(configuration.error().front()) << "\n" << text;
        return Json::object();
    }
    const std::string toml = effective_toml(*configuration);
    EXPECT_EQ(mistakes_in(toml, file), std::vector<std::string>{}) << toml;
    const auto again = load_configuration(toml, file);
    if (again) {
        EXPECT_EQ(effective_toml(*again), toml);
        EXPECT_EQ(effective_json(*again), effective_json(*configuration));
    }
    return Json::parse(effective_json(*configuration));
}

/// A default that the row has in words which are nothing but a value: "`false`".
bool is_value_in_words(std::string_view absent) {
    return absent.size() > 2 && absent.starts_with('`') && absent.ends_with('`') &&
           std::ranges::count(absent, '`') == 2;
}

/// Every row with a default that applies is in the table.
void expect_defaults(const Json& table, std::span<const Key> rows, const Applies& applies,
                     const std::string& name) {
    for (const Key& row : rows) {
        const bool has_default =
            default_of(row).has_value() || is_value_in_words(row.setting.absent);
        if (has_default && row.kind != KeyKind::presets && applies(row.name())) {
            EXPECT_TRUE(table.contains(row.name()))
                << row.name() << " is not printed for " << name << "\n"
                << table.dump(2);
        }
    }
}

std::string main_job_and(std::string_view more) {
    return std::string(kReceiverTable) + std::string(kServosTable) + std::string(kPipelineTable) +
           std::string(more);
}

/// Lines that a protocol needs beside its required keys.
std::string_view needed_by(const Protocol& protocol, SettingScope way) {
    static const std::map<std::string_view, std::string_view> kNeeded{
        {"crsf-telemetry", "vario = \"probes.1\"\n"},
        {"dronecan", "node_id = 42\n"},
    };
    const auto needed = kNeeded.find(protocol.name);
    return needed == kNeeded.end() || way == SettingScope::input ? "" : needed->second;
}

/// Keys that are required, with their examples.
std::string required_lines(std::span<const Key> rows, SettingScope way) {
    std::string lines;
    for (const Key& row : rows) {
        const bool other = way == SettingScope::output && !row.setting.output_example.empty();
        const std::string_view example = other ? row.setting.output_example : row.setting.example;
        if (row.setting.required && row.kind == KeyKind::value) {
            lines += std::string(row.name()) + " = " + std::string(example) + "\n";
        }
    }
    return lines;
}

std::string minimal_job(const Protocol& protocol, const Medium& medium, SettingScope way) {
    const auto rows = protocol_keys(protocol, medium, way);
    const std::string lines = "protocol = \"" + std::string(protocol.name) + "\"\n" +
                              required_lines(rows, way) + std::string(needed_by(protocol, way));
    const bool in = way == SettingScope::input;
    const bool sends_values =
        !in && (protocol.name.ends_with("-telemetry") || protocol.name == "sensors");
    const std::string port = (in ? "[input.receiver]\n" : "[output.servos]\n") + lines;
    if (sends_values) {
        return "[output.other]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyC\"\n" +
               std::string(kReceiverTable) +
               "[pipeline.main]\nfrom = \"receiver\"\nto = \"other\"\n" + port +
               "[sensor_bus.probes]\nrole = \"receiver\"\ndevice = \"/dev/ttyD\"\n";
    }
    return port + std::string(in ? kServosTable : kReceiverTable) + std::string(kPipelineTable);
}

/// Whether a row of an input applies to the protocol.
bool applies_to_input(const Protocol& protocol, std::string_view key) {
    if (key == "zero_guard") {
        return protocol.raw_zero != nullptr;
    }
    return !is_about_flags(key) || has_flags(protocol, {});
}

class Defaults : public ::testing::Test {
  protected:
    Defaults() {
        folder_.write("rover.dbc", R"(BO_ 256 Command: 8 A
 SG_ Steering : 0|8@1+ (1,0) [0|250] "" B
 SG_ Lost : 14|1@1+ (1,0) [0|1] "" B
BO_ 512 Battery: 2 A
 SG_ Voltage : 0|16@1+ (0.001,0) [0|60] "V" B
)");
    }

    Json printed_here(const std::string& text) const { return printed(text, folder_ / "t.toml"); }

  private:
    test::TemporaryFolder folder_;
};

TEST_F(Defaults, ArePrintedForEveryProtocolOnEveryMediumInBothDirections) {
    std::size_t count = 0;
    for (const Protocol* protocol : protocols()) {
        for (const SettingScope way : {SettingScope::input, SettingScope::output}) {
            for (const Medium* medium : media_for(*protocol)) {
                if (!protocol->goes(way)) {
                    continue;
                }
                const bool in = way == SettingScope::input;
                Json all = printed_here(minimal_job(*protocol, *medium, way));
                const Json& table = in ? all["input"]["receiver"] : all["output"]["servos"];
                const std::string name = std::string(protocol->name) +
                                         (in ? " in on " : " out on ") + std::string(medium->name);
                const auto applies = [&](std::string_view key) {
                    return !in || applies_to_input(*protocol, key);
                };
                expect_defaults(table, in ? input_keys() : output_keys(), applies, name);
                expect_defaults(table, protocol_keys(*protocol, *medium, way), to_all, name);
                ++count;
            }
        }
    }
    EXPECT_GT(count, 40U);
}

/// A default that depends on other keys, which the manual has in words.
struct DependentDefault {
    std::string lines;  ///< of an input or output, without its header
    std::string key;
    Json value;
};

TEST_F(Defaults, ArePrintedAsJsonThatAPersonCanRead) {
    const std::string json = effective_json(loaded(main_job_with(10, "")));
    EXPECT_TRUE(json.starts_with("{\n  \"runtime\": {\n    \"realtime\": \"auto\",\n")) << json;
    EXPECT_TRUE(json.ends_with("\n  }\n}\n")) << json;
}

TEST_F(Defaults, ThatDependOnOtherKeysArePrinted) {
    const std::string mavlink = "protocol = \"mavlink\"\ndevice = \"/dev/ttyC\"\n";
    const std::string dronecan = "protocol = \"dronecan\"\ninterface = \"can0\"\nnode_id = 42\n";
    const std::vector<DependentDefault> defaults{
        {mavlink, "message", "radio_rc_channels"},
        {mavlink, "system", 255},
        {mavlink, "channels", 16},
        {mavlink + "message = \"rc_channels_override\"\nversion = 1\n", "channels", 8},
        {mavlink + "message = \"manual_control\"\n", "channels", nullptr},
        {mavlink + "message = \"manual_control\"\n", "throttle", "zero based"},
        {mavlink, "throttle", nullptr},
        {mavlink, "link_id", nullptr},
        {dronecan, "channels", 18},
        {dronecan, "receiver", 0},
        {dronecan + "carries = \"servos\"\n", "channels", 4},
        {dronecan + "carries = \"servos\"\n", "first", 1},
        {dronecan + "carries = \"motors\"\n", "first", 0},
        {dronecan + "carries = \"motors\"\n", "receiver", nullptr},
    };
    for (const auto& [lines, key, value] : defaults) {
        Json all = printed_here("[output.servos]\n" + lines + std::string(kReceiverTable) +
                                std::string(kPipelineTable));
        const Json& table = all["output"]["servos"];
        EXPECT_EQ(table.contains(key) ? table[key] : Json(), value) << key << "\n" << lines;
    }
}

TEST_F(Defaults, NameNoSenderForInputsThatListenToTheFirst) {
    Json all = printed_here("[input.receiver]\nprotocol = \"mavlink\"\ndevice = \"/dev/ttyA\"\n" +
                            std::string(kServosTable) + std::string(kPipelineTable));
    EXPECT_FALSE(all["input"]["receiver"].contains("system"));
    EXPECT_FALSE(all["input"]["receiver"].contains("message"));
}

TEST_F(Defaults, AreThoseOfTheManualForMaps) {
    Json pad = printed_here(
        "[input.receiver]\nprotocol = \"gamepad\"\n"
        "device = \"/dev/input/event0\"\n" +
        std::string(kServosTable) + std::string(kPipelineTable))["input"]["receiver"];
    EXPECT_EQ(pad["axes"].dump(),
              R"({"ABS_RX":1,"ABS_RY":2,"ABS_X":4,"ABS_Y":{"channel":3,"reverse":true}})");
    EXPECT_EQ(pad["buttons"].dump(), R"({"BTN_EAST":6,"BTN_NORTH":8,"BTN_SOUTH":5,"BTN_WEST":7})");
    Json stick =
        printed_here("[output.servos]\nprotocol = \"joystick\"\nname = \"tribus\"\n" +
                     std::string(kReceiverTable) + std::string(kPipelineTable))["output"]["servos"];
    EXPECT_EQ(stick["axes"]["ABS_RUDDER"], 8);
    EXPECT_EQ(stick["buttons"]["1"], 9);
    EXPECT_EQ(stick["buttons"]["10"], 18);
}

TEST_F(Defaults, ArePrintedForTablesThatAreThereOnce) {
    Json all = printed_here(main_job_and("[recorder]\ndirectory = \"/tmp\"\n"));
    expect_defaults(all["runtime"], runtime_keys(), to_all, "runtime");
    expect_defaults(all["recorder"], recorder_keys(), to_all, "recorder");
}

TEST_F(Defaults, ArePrintedForPipelines) {
    Json all = printed_here(main_job_and("[pipeline.main.channels]\n1 = { from = 2, trim = 5 }\n"));
    Json& pipeline = all["pipeline"]["main"];
    const Applies without_vote = [](std::string_view key) { return key != "tolerance"; };
    expect_defaults(pipeline, pipeline_keys(), without_vote, "pipeline");
    expect_defaults(pipeline["failsafe"]["output"]["servos"], output_failsafe_keys(), to_all,
                    "failsafe");
    expect_defaults(pipeline["channels"]["1"], channel_keys(), to_all, "channel");
}

TEST_F(Defaults, IncludeTheToleranceOfAMedian) {
    Json all = printed_here(std::string(kReceiverTable) + std::string(kServosTable) +
                            "[input.b]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyC\"\n"
                            "[input.c]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyD\"\n"
                            "[pipeline.main]\nfrom = [\"receiver\", \"b\", \"c\"]\nto = "
                            "\"servos\"\nmode = \"median\"\n");
    expect_defaults(all["pipeline"]["main"], pipeline_keys(), to_all, "pipeline");
}

TEST_F(Defaults, ArePrintedForLinesOfEveryRole) {
    for (const std::string_view word : ChoiceWords<LineRole>::kAll) {
        const LineRole role = *choice_named<LineRole>(word);
        std::string lines = "[gpio.x]\nline = \"GPIO17\"\nrole = \"" + std::string(word) + "\"\n";
        if (role == LineRole::select) {
            lines += "input = \"b\"\n[input.b]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyC\"\n";
        } else if (role == LineRole::channel_switch) {
            lines += "output = \"servos\"\nchannel = 9\nabove = 1700\n";
        } else if (role == LineRole::button) {
            lines += "[pipeline.main.channels]\n9 = { line = \"x\" }\n";
        }
        const bool selects = role == LineRole::select;
        Json all = printed_here(
            std::string(kReceiverTable) + std::string(kServosTable) + lines +
            "[pipeline.main]\nfrom = " + (selects ? "[\"receiver\", \"b\"]" : "\"receiver\"") +
            "\nto = \"servos\"\n");
        expect_defaults(
            all["gpio"]["x"], line_keys(),
            [role](std::string_view key) { return role_has(role, key); },
            "line " + std::string(word));
    }
}

TEST_F(Defaults, ArePrintedForSensorBusesOfBothRoles) {
    Json all = printed_here(main_job_and(
        "[values.battery]\nconstant = 12\nunit = \"V\"\n"
        "[sensor_type.own]\nid = 81\n"
        "[sensor_bus.sensor]\ndevice = \"/dev/ttyD\"\nrole = \"sensor\"\n"
        "[[sensor_bus.sensor.sensor]]\ntype = \"external_voltage\"\nvalue = \"battery\"\n"
        "[sensor_bus.receiver]\ndevice = \"/dev/ttyE\"\nrole = \"receiver\"\n"));
    for (const BusRole role : {BusRole::sensor, BusRole::receiver}) {
        const std::string name(word_of(role));
        expect_defaults(
            all["sensor_bus"][name], sensor_bus_keys(),
            [role](std::string_view key) { return bus_role_has(role, key); }, name);
    }
    expect_defaults(all["sensor_bus"]["sensor"]["sensor"][0], sensor_keys(), to_all, "sensor");
    expect_defaults(all["sensor_type"]["own"], sensor_type_keys(), to_all, "sensor_type");
}

TEST_F(Defaults, ArePrintedForValuesOfEveryKind) {
    Json all = printed_here(main_job_and(
        "[dronecan.node]\ninterface = \"can0\"\nnode_id = 7\n"
        "[values.dbc]\ninterface = \"can0\"\ndbc = \"rover.dbc\"\nmessage = \"Battery\"\n"
        "[values.bus]\ninterface = \"can0\"\ndronecan = \"uavcan.equipment.power.BatteryInfo\"\n"
        "[values.line]\nprotocol = \"crsf-telemetry\"\ndevice = \"/dev/ttyD\"\n"
        "[values.udp]\nprotocol = \"crsf-telemetry\"\naddress = \"127.0.0.1:5501\"\n"));
    expect_defaults(all["dronecan"]["node"], dronecan_keys(), to_all, "dronecan");
    EXPECT_TRUE(all["values"]["dbc"].contains("timeout"));
    EXPECT_EQ(all["values"]["bus"]["fd"], false);
    EXPECT_EQ(all["values"]["bus"]["timeout"], "3s");
    EXPECT_EQ(all["values"]["line"]["baud"], 420000);
    EXPECT_EQ(all["values"]["udp"]["public"], false);
    EXPECT_EQ(all["values"]["udp"]["timeout"], "3s");
}

}  // namespace
}  // namespace tribus::test::defaults_test
