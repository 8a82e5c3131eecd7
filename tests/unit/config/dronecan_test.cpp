#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/build/build.h"
#include "config/build/dronecan.h"
#include "config/load.h"
#include "config/show/effective.h"
#include "transports/links/can/can_medium.h"

namespace tribus::dronecan_test {
namespace {

constexpr std::string_view kReceiver = R"([input.receiver]
protocol = "ibus"
device = "/dev/ttyAMA5"

[pipeline.main]
from = "receiver"
to = "autopilot"
)";

/// Returns a receiver that feeds [output.autopilot] with these lines.
std::string with_output(const std::string& lines, const std::string& more = {}) {
    return std::string(kReceiver) +
           "\n[output.autopilot]\nprotocol = \"dronecan\"\ninterface = \"can1\"\n" + lines + "\n" +
           more;
}

/// Returns all mistakes, one a line, or an empty text.
std::string mistakes_of(const std::string& text) {
    const auto loaded = load_configuration(text, "test.toml");
    std::string all;
    if (!loaded) {
        for (const Mistake& mistake : loaded.error()) {
            all += format_mistake(mistake) + "\n";
        }
    }
    return all;
}

Configuration load(const std::string& text) {
    auto loaded = load_configuration(text, "test.toml");
    EXPECT_TRUE(loaded) << mistakes_of(text);
    return loaded ? std::move(*loaded) : Configuration{};
}

TEST(DroneCanConfiguration, TakesTheNodeOfTheContract) {
    const Configuration configuration = load(with_output("node_id = 42"));
    const auto nodes = plan_nodes(configuration, "machine");
    ASSERT_EQ(nodes.size(), 1U);
    EXPECT_EQ(nodes[0].port.device, "can1");
    EXPECT_EQ(nodes[0].settings.id, 42);
    EXPECT_FALSE(nodes[0].settings.dynamic);
    EXPECT_FALSE(nodes[0].settings.may_restart);
    EXPECT_FALSE(nodes[0].settings.may_write);
    EXPECT_EQ(nodes[0].settings.name, "org.tribus");
}

TEST(DroneCanConfiguration, TakesTheNodeOfATable) {
    const Configuration configuration =
        load(with_output("",
                         "[dronecan.bus]\ninterface = \"can1\"\nnode_id = 7\n"
                         "name = \"rover.rc\"\nallow_restart = true\nallow_writes = true\n"));
    const auto nodes = plan_nodes(configuration, {});
    ASSERT_EQ(nodes.size(), 1U);
    EXPECT_EQ(nodes[0].settings.id, 7);
    EXPECT_EQ(nodes[0].settings.name, "rover.rc");
    EXPECT_TRUE(nodes[0].settings.may_restart);
    EXPECT_TRUE(nodes[0].settings.may_write);
}

TEST(DroneCanConfiguration, AsksForAnIdWhereItIsToldTo) {
    const Configuration configuration =
        load(with_output("", "[dronecan.bus]\ninterface = \"can1\"\ndynamic = true\n"));
    EXPECT_TRUE(plan_nodes(configuration, {})[0].settings.dynamic);
}

TEST(DroneCanConfiguration, MakesAUniqueIdOfTheMachineAndTheInterface) {
    const Configuration configuration = load(with_output("node_id = 42"));
    const auto id = [&](std::string_view machine) {
        return plan_nodes(configuration, machine)[0].settings.unique_id;
    };
    EXPECT_EQ(id("a"), id("a"));
    EXPECT_NE(id("a"), id("b"));
    EXPECT_NE(id(""), dronecan::UniqueId{});
}

TEST(DroneCanConfiguration, ShowsThePeriodsOfOutputsAsParameters) {
    const Configuration configuration = load(with_output("node_id = 42\nperiod = \"20ms\""));
    const auto parameters = plan_nodes(configuration, {})[0].settings.parameters;
    ASSERT_EQ(parameters.size(), 2U);
    EXPECT_EQ(parameters[0].name, "uavcan.node_id");
    EXPECT_FALSE(parameters[0].output);
    EXPECT_EQ(parameters[1].name, "uavcan.pubp-RCInput");
    EXPECT_EQ(parameters[1].value, 20000);
    EXPECT_EQ(parameters[1].least, 10000);
    EXPECT_EQ(parameters[1].output, std::optional<std::size_t>(0));
}

TEST(DroneCanConfiguration, AsksForANodeIdWhereThereIsNone) {
    EXPECT_EQ(mistakes_of(with_output("")),
              "test.toml:9:9: [output.autopilot] has no node_id; required: one of 1 to 125 that "
              "no other node on \"can1\" has, here or in a table [dronecan.NAME] with that "
              "interface\n");
}

TEST(DroneCanConfiguration, AsksForANodeIdOfATableThatNobodyGivesOne) {
    EXPECT_EQ(mistakes_of(std::string(kReceiver) +
                          "[output.autopilot]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                          "[dronecan.bus]\ninterface = \"can1\"\n"),
              "test.toml:11:11: [dronecan.bus] has no node_id; required: one of 1 to 125 that no "
              "other node on \"can1\" has, or dynamic = true\n");
}

TEST(DroneCanConfiguration, TakesTheIdOfAnOutputForATableThatHasNone) {
    const Configuration configuration =
        load(with_output("node_id = 42", "[dronecan.bus]\ninterface = \"can1\"\n"));
    EXPECT_EQ(plan_nodes(configuration, {})[0].settings.id, 42);
}

TEST(DroneCanConfiguration, RefusesTwoIdsOnOneInterface) {
    const std::string mistakes = mistakes_of(
        with_output("node_id = 42", "[dronecan.bus]\ninterface = \"can1\"\nnode_id = 7\n"));
    EXPECT_NE(mistakes.find("the node_id of [output.autopilot] is 42, that of [dronecan.bus] in "
                            "line 15 is 7; allowed: one node on an interface"),
              std::string::npos)
        << mistakes;
}

TEST(DroneCanConfiguration, RefusesTwoTablesForOneInterface) {
    const std::string mistakes =
        mistakes_of(with_output("",
                                "[dronecan.a]\ninterface = \"can1\"\nnode_id = 7\n[dronecan.b]\n"
                                "interface = \"can1\"\n"));
    EXPECT_NE(mistakes.find("[dronecan.a] is already a node on \"can1\""), std::string::npos)
        << mistakes;
}

TEST(DroneCanConfiguration, RefusesAMessageThatTwoOutputsSend) {
    const std::string mistakes =
        mistakes_of(with_output("node_id = 42",
                                "[output.second]\nprotocol = \"dronecan\"\n"
                                "interface = \"can1\"\n[pipeline.b]\nfrom = \"receiver\"\n"
                                "to = \"second\"\n"));
    EXPECT_NE(mistakes.find("[output.autopilot] in line 9 sends the same message on \"can1\""),
              std::string::npos)
        << mistakes;
}

TEST(DroneCanConfiguration, TakesTheSameMessageOfTwoReceivers) {
    EXPECT_EQ(mistakes_of(with_output("node_id = 42",
                                      "[output.second]\nprotocol = \"dronecan\"\nreceiver = 1\n"
                                      "interface = \"can1\"\n[pipeline.b]\nfrom = \"receiver\"\n"
                                      "to = \"second\"\n")),
              "");
}

TEST(DroneCanConfiguration, NamesKeysThatAreForOtherMessages) {
    for (const char* line :
         {"first = 2", "arms = true", "command = \"pulse\"", "reversible = true"}) {
        const std::string mistakes = mistakes_of(with_output(std::string("node_id = 42\n") + line));
        EXPECT_NE(mistakes.find("leave it out"), std::string::npos) << line << mistakes;
    }
    for (const char* line : {"receiver = 2", "quality = \"none\"", "quality_type = \"snr\""}) {
        const std::string mistakes =
            mistakes_of(with_output(std::string("node_id = 42\ncarries = \"servos\"\n") + line));
        EXPECT_NE(mistakes.find("leave it out"), std::string::npos) << line << mistakes;
    }
}

// The specification reserves 126 and 127 for tools.
TEST(DroneCanConfiguration, RefusesTheIdsOfToolsForItself) {
    EXPECT_EQ(mistakes_of(with_output("node_id = 125")), "");
    EXPECT_EQ(mistakes_of(with_output("", "[dronecan.bus]\ninterface = \"can1\"\nnode_id = 125\n")),
              "");
    for (const char* line : {"node_id = 126", "node_id = 127"}) {
        for (const std::string& text :
             {with_output(line),
              with_output("",
                          std::string("[dronecan.bus]\ninterface = \"can1\"\n") + line + "\n")}) {
            const std::string mistakes = mistakes_of(text);
            EXPECT_NE(mistakes.find("1 to 125"), std::string::npos) << line << mistakes;
        }
    }
}

TEST(DroneCanConfiguration, RefusesMoreMotorsThanAMessageHolds) {
    const std::string mistakes =
        mistakes_of(with_output("node_id = 42\ncarries = \"motors\"\nfirst = 10\nchannels = 11"));
    EXPECT_NE(mistakes.find("21 do not fit into one message; allowed: 20 motors"),
              std::string::npos)
        << mistakes;
}

TEST(DroneCanConfiguration, RefusesMoreThan100MessagesASecondUnlessForced) {
    EXPECT_NE(mistakes_of(with_output("node_id = 42\nperiod = \"5ms\"")), "");
    EXPECT_EQ(mistakes_of(with_output("node_id = 42\nperiod = \"5ms\"\nforce = true")), "");
}

TEST(DroneCanConfiguration, RefusesToCommandServosOrMotorsLessThan25TimesASecond) {
    for (const std::string carries : {"servos", "motors"}) {
        const std::string command = "node_id = 42\ncarries = \"" + carries + "\"\n";
        EXPECT_EQ(mistakes_of(with_output(command + "period = \"41ms\"")),
                  "test.toml:14:10: \"period\" is \"41ms\", longer than readers of "
                  "\"dronecan\" wait for the next command; allowed: \"10ms\" to \"40ms\"\n");
        EXPECT_EQ(mistakes_of(with_output(command + "period = \"40ms\"")), "");
    }
}

TEST(DroneCanConfiguration, RefusesASlowCommandEvenIfForced) {
    EXPECT_NE(mistakes_of(with_output(
                  "node_id = 42\ncarries = \"servos\"\nperiod = \"41ms\"\nforce = true")),
              "");
}

TEST(DroneCanConfiguration, TellsThatCommandsHaveALeastAndALongestPeriod) {
    const std::string mistakes =
        mistakes_of(with_output("node_id = 42\ncarries = \"motors\"\nperiod = \"5ms\""));
    EXPECT_NE(mistakes.find("allowed: \"10ms\" to \"40ms\", or add force = true"),
              std::string::npos)
        << mistakes;
}

TEST(DroneCanConfiguration, SendsRcLessThan25TimesASecondIfToldTo) {
    EXPECT_EQ(mistakes_of(with_output("node_id = 42\nperiod = \"41ms\"")), "");
}

TEST(DroneCanConfiguration, OthersCannotSlowCommandsBelow25TimesASecond) {
    const Configuration configuration = load(with_output("node_id = 42\ncarries = \"servos\""));
    const auto parameters = plan_nodes(configuration, {})[0].settings.parameters;
    ASSERT_EQ(parameters.size(), 2U);
    EXPECT_EQ(parameters[1].name, "uavcan.pubp-ArrayCommand");
    EXPECT_EQ(parameters[1].most, 40000);
}

TEST(DroneCanConfiguration, RefusesANameThatNoNodeMayHave) {
    const std::string mistakes = mistakes_of(
        with_output("", "[dronecan.bus]\ninterface = \"can1\"\nnode_id = 7\nname = \"Rover 1\"\n"));
    EXPECT_NE(mistakes.find("\"Rover 1\" is not a node name; allowed: 1 to 50 small letters"),
              std::string::npos)
        << mistakes;
}

TEST(DroneCanConfiguration, TakesNamesOfFiftySmallLettersDigitsAndMarks) {
    const auto with = [](const std::string& name) {
        return mistakes_of(with_output(
            "", "[dronecan.bus]\ninterface = \"can1\"\nnode_id = 7\nname = \"" + name + "\"\n"));
    };
    EXPECT_EQ(with("az.09_-"), "");
    EXPECT_EQ(with(std::string(50, 'a')), "");
    EXPECT_NE(with(std::string(51, 'a')), "");
}

TEST(DroneCanConfiguration, TakesOneIdThatTwoOutputsName) {
    EXPECT_EQ(mistakes_of(with_output("node_id = 42",
                                      "[output.second]\nprotocol = \"dronecan\"\nreceiver = 1\n"
                                      "interface = \"can1\"\nnode_id = 42\n"
                                      "[pipeline.b]\nfrom = \"receiver\"\nto = \"second\"\n")),
              "");
}

TEST(DroneCanConfiguration, NamesThePlaceOfTheSecondTable) {
    EXPECT_EQ(
        mistakes_of(with_output("",
                                "[dronecan.a]\ninterface = \"can1\"\nnode_id = 7\n"
                                "[dronecan.b]\ninterface = \"can1\"\n")),
        "test.toml:17:13: [dronecan.a] is already a node on \"can1\"; allowed: one node on an "
        "interface, for all its outputs\n");
}

TEST(DroneCanConfiguration, HasTheDefaultsOfWhatAnOutputCarries) {
    const Configuration configuration = load(with_output("node_id = 42"));
    const auto* receiver = configuration.outputs.at(0).settings.find_as<std::int64_t>("receiver");
    ASSERT_NE(receiver, nullptr);
    EXPECT_EQ(*receiver, 0);
}

TEST(DroneCanConfiguration, HasItsNodeOnCan) {
    const Configuration configuration =
        load(with_output("", "[dronecan.bus]\ninterface = \"can1\"\nnode_id = 7\n"));
    EXPECT_EQ(configuration.dronecan.at(0).port.medium, &kCanMedium);
}

TEST(DroneCanConfiguration, NamesAQualityThatNobodyGives) {
    const std::string mistakes = mistakes_of(with_output("node_id = 42\nquality = \"radio.rssi\""));
    EXPECT_NE(mistakes.find("radio.rssi"), std::string::npos) << mistakes;
}

TEST(DroneCanConfiguration, NeedsNoNodeToListen) {
    const Configuration configuration = load(
        "[input.radio]\nprotocol = \"dronecan\"\ninterface = \"can0\"\nfrom_node = 42\n"
        "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyAMA3\"\n"
        "[pipeline.main]\nfrom = \"radio\"\nto = \"servos\"\n");
    EXPECT_TRUE(plan_nodes(configuration, {}).empty());
    EXPECT_EQ(build_engine(configuration)->inputs().size(), 1U);
}

TEST(DroneCanConfiguration, IsTheSameAfterItWasPrinted) {
    const Configuration configuration = load(
        with_output("carries = \"servos\"\nfirst = 3\narms = true",
                    "[dronecan.bus]\ninterface = \"can1\"\nnode_id = 7\nname = \"rover.rc\"\n"));
    const std::string printed = effective_toml(configuration);
    EXPECT_EQ(effective_toml(load(printed)), printed);
}

TEST(DroneCanConfiguration, PutsTheNodeOnThePortOfItsInterface) {
    const auto plans = plan_ports(load(with_output("node_id = 42")));
    const auto can = std::ranges::find_if(
        plans, [](const PortPlan& plan) { return plan.config.device == "can1"; });
    ASSERT_NE(can, plans.end());
    EXPECT_EQ(can->wiring.stations,
              (std::vector<Station>{{StationKind::output, 0}, {StationKind::dronecan_node, 0}}));
}

TEST(DroneCanConfiguration, MakesTheSameUniqueIdForEver) {
    const auto settings = plan_nodes(load(with_output("node_id = 42")), "machine")[0].settings;
    EXPECT_EQ(settings.unique_id,
              (dronecan::UniqueId{0x4F, 0x43, 0xCF, 0xE9, 0xC2, 0x83, 0xF6, 0x09, 0x02, 0x7E, 0xB4,
                                  0xE4, 0x18, 0x97, 0x6E, 0xCD}));
    EXPECT_EQ(settings.seed, 0x40E33575B71AB755U);
}

TEST(DroneCanConfiguration, ShowsTheLimitsOfItsParameters) {
    const auto parameters = [](const std::string& lines) {
        return plan_nodes(load(with_output("node_id = 42\n" + lines)), {})[0].settings.parameters;
    };
    const auto usual = parameters("");
    ASSERT_EQ(usual.size(), 2U);
    EXPECT_EQ(usual[0].value, 42);
    EXPECT_EQ(usual[0].at_start, 42);
    EXPECT_EQ(usual[0].least, 0);
    EXPECT_EQ(usual[0].most, 127);
    EXPECT_EQ(usual[1].value, 10000);
    EXPECT_EQ(usual[1].at_start, 10000);
    EXPECT_EQ(usual[1].least, 10000);
    EXPECT_EQ(usual[1].most, 1'000'000);
    EXPECT_EQ(parameters("period = \"5ms\"\nforce = true")[1].least, 5000);
    EXPECT_EQ(parameters("carries = \"motors\"")[1].name, "uavcan.pubp-RawCommand");
}

TEST(DroneCanConfiguration, IsOneNodeOnEachInterface) {
    const auto nodes = plan_nodes(
        load(with_output("node_id = 42",
                         "[dronecan.other]\ninterface = \"can2\"\nnode_id = 7\n"
                         "[output.second]\nprotocol = \"dronecan\"\ninterface = \"can1\"\n"
                         "receiver = 1\n[pipeline.b]\nfrom = \"receiver\"\nto = \"second\"\n")),
        {});
    ASSERT_EQ(nodes.size(), 2U);
    EXPECT_EQ(node_on(nodes, "can2"), 0U);
    EXPECT_EQ(node_on(nodes, "can1"), 1U);
    EXPECT_EQ(node_on(nodes, "can3"), std::nullopt);
    EXPECT_EQ(nodes[1].settings.parameters.size(), 3U);
    EXPECT_EQ(nodes[1].settings.parameters[2].output, std::optional<std::size_t>(1));
    EXPECT_EQ(nodes[0].settings.parameters.size(), 1U);
}

}  // namespace
}  // namespace tribus::dronecan_test
