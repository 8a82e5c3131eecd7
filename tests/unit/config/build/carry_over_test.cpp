#include "config/build/carry_over.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "tests/unit/config/main_job.h"

/// Parts that continue when a configuration replaces another.
namespace tribus::test::carry_over_test {
namespace {

std::string replaced(std::string text, std::string_view what, std::string_view with) {
    text.replace(text.find(what), what.size(), with);
    return text;
}

const std::string kJob = main_job_with(0, "");

/// Returns what carries over from the nine lines to the new text.
CarryOver carry_over(std::string_view fresh, std::string_view running = kJob) {
    return plan_carry_over(loaded(running), loaded(fresh));
}

TEST(CarryOver, IsAllForTheSameConfiguration) {
    const CarryOver plan = carry_over(kJob);
    EXPECT_EQ(plan.engine.inputs[0].from, 0U);
    EXPECT_TRUE(plan.engine.inputs[0].same_channels);
    EXPECT_EQ(plan.engine.outputs[0].from, 0U);
    EXPECT_TRUE(plan.engine.outputs[0].same_channels);
    EXPECT_TRUE(plan.engine.outputs[0].same_schedule);
    EXPECT_TRUE(plan.engine.outputs[0].same_failsafe);
    EXPECT_TRUE(plan.leaving.empty());
    EXPECT_TRUE(plan.obstacles.empty());
}

TEST(CarryOver, DoesNotMindWhereInTheFileThingsStand) {
    const CarryOver plan = carry_over("\n\n# moved\n" + kJob);
    EXPECT_EQ(plan.engine.inputs[0].from, 0U);
    EXPECT_TRUE(plan.engine.outputs[0].same_channels);
}

TEST(CarryOver, KeepsAnOutputWhoseMapPeriodAndFailsafeChanged) {
    const CarryOver plan =
        carry_over(replaced(kJob, "[pipeline.main]", "period = \"20ms\"\n[pipeline.main]") +
                   "[pipeline.main.channels]\n1 = 2\n"
                   "[pipeline.main.failsafe]\nhold = \"1s\"\n");
    EXPECT_EQ(plan.engine.outputs[0].from, 0U);
    EXPECT_FALSE(plan.engine.outputs[0].same_channels);
    EXPECT_FALSE(plan.engine.outputs[0].same_schedule);
    EXPECT_FALSE(plan.engine.outputs[0].same_failsafe);
    EXPECT_TRUE(plan.leaving.empty());
}

TEST(CarryOver, KeepsAnInputWhoseTimeoutChanged) {
    const CarryOver plan =
        carry_over(replaced(kJob, "[output.servos]", "timeout = \"1s\"\n[output.servos]"));
    EXPECT_EQ(plan.engine.inputs[0].from, 0U);
}

TEST(CarryOver, KeepsNeitherInputNorOutputOfAnotherProtocol) {
    const CarryOver plan =
        carry_over(replaced(replaced(replaced(kJob, "\"ibus\"", "\"x\""), "\"sbus\"", "\"ibus\""),
                            "\"x\"", "\"sbus\""));
    EXPECT_EQ(plan.engine.inputs[0].from, std::nullopt);
    EXPECT_EQ(plan.engine.outputs[0].from, std::nullopt);
    EXPECT_EQ(plan.leaving.outputs, std::vector<std::size_t>{0});
}

TEST(CarryOver, KeepsNoInputOnAnotherDevice) {
    EXPECT_EQ(carry_over(replaced(kJob, "/dev/ttyA", "/dev/ttyC")).engine.inputs[0].from,
              std::nullopt);
}

TEST(CarryOver, TakesTheOutputOfTheNameWhateverTheOrder) {
    const std::string second = "[output.tail]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyD\"\n";
    const std::string both = replaced(kJob, "[pipeline.main]", second + "[pipeline.main]");
    const std::string swapped = replaced(
        replaced(
            replaced(both, "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n", "@"),
            second, "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"),
        "@", second);
    const std::string to = "to = [\"servos\", \"tail\"]";
    const CarryOver plan =
        carry_over(replaced(swapped, "to = \"servos\"", to), replaced(both, "to = \"servos\"", to));
    EXPECT_EQ(plan.engine.outputs[0].from, 1U);
    EXPECT_EQ(plan.engine.outputs[1].from, 0U);
}

TEST(CarryOver, SaysWhatCannotChangeWithoutAStop) {
    EXPECT_EQ(carry_over(kJob + "[runtime]\npriority = 70\n").obstacles.size(), 1U);
    EXPECT_EQ(
        carry_over(kJob + "[gpio.lamp]\nline = \"GPIO17\"\nrole = \"link\"\n").obstacles.size(),
        1U);
    const std::string lamp = "[gpio.lamp]\nline = \"GPIO17\"\nrole = \"link\"\n";
    EXPECT_EQ(carry_over(kJob + lamp, kJob + lamp).obstacles.size(), 0U);
    const std::string pulses = "protocol = \"ppm\"\nline = \"/dev/spidev0.0\"\n";
    const std::string drawn = "protocol = \"sbus\"\nspi = \"/dev/spidev0.0\"\n";
    const auto with = [](const std::string& output) {
        return kJob + "[output.other]\n" + output +
               "[pipeline.other]\nfrom = \"receiver\"\nto = \"other\"\n";
    };
    EXPECT_EQ(carry_over(with(drawn), with(pulses)).obstacles,
              std::vector<std::string>{
                  "/dev/spidev0.0 is used in another way, and must be closed first"});
    const std::string renamed =
        replaced(replaced(kJob, "[output.servos]", "[output.wings]"), "\"servos\"", "\"wings\"");
    EXPECT_EQ(carry_over(renamed + lamp, kJob + lamp).obstacles,
              std::vector<std::string>{
                  "inputs or outputs that GPIO lines refer to were added or removed"});
    EXPECT_EQ(carry_over(kJob + "[runtime]\nspin = \"100us\"\n").obstacles.size(), 0U);
}

TEST(CarryOver, KeepsASensorBusAndItsValuesWhereItIsTheSame) {
    const std::string bus = "[sensor_bus.probes]\nrole = \"receiver\"\ndevice = \"/dev/ttyS\"\n";
    const std::string front = "[sensor_bus.another]\nrole = \"receiver\"\ndevice = \"/dev/ttyT\"\n";
    const CarryOver plan = carry_over(kJob + front + bus, kJob + bus);
    ASSERT_EQ(plan.values.buses.size(), 2U);
    EXPECT_EQ(plan.values.buses[0], std::nullopt);
    EXPECT_EQ(plan.values.buses[1], 0U);
    EXPECT_FALSE(plan.values.values.empty());
    const CarryOver changed = carry_over(kJob + bus + "probe_every = 7\n", kJob + bus);
    EXPECT_EQ(changed.values.buses[0], std::nullopt);
}

TEST(CarryOver, KeepsTheReaderOfAMessageAndItsValuesWhereItIsTheSame) {
    const std::string probes = "[sensor_bus.probes]\nrole = \"receiver\"\ndevice = \"/dev/ttyS\"\n";
    const auto message = [](const std::string& name, const std::string& more = "") {
        return "[values." + name +
               "]\ninterface = \"can0\"\ndronecan = \"uavcan.equipment.power.BatteryInfo\"\n" +
               more;
    };
    const std::string running = kJob + probes + message("battery");
    const CarryOver plan =
        carry_over(kJob + probes + message("another", "node = 7\n") + message("battery"), running);
    ASSERT_EQ(plan.values.messages.size(), 2U);
    EXPECT_EQ(plan.values.messages[0], std::nullopt);
    EXPECT_EQ(plan.values.messages[1], 0U);
    const CarryOver changed = carry_over(kJob + probes + message("battery", "node = 7\n"), running);
    EXPECT_EQ(changed.values.messages[0], std::nullopt);
}

TEST(CarryOver, KeepsANodeOfDroneCanWithTheSameIdOnTheSameInterface) {
    const auto job = [](int id) {
        return replaced(
            kJob, "protocol = \"sbus\"\ndevice = \"/dev/ttyB\"",
            "protocol = \"dronecan\"\ninterface = \"can0\"\nnode_id = " + std::to_string(id));
    };
    EXPECT_EQ(carry_over(job(42), job(42)).engine.nodes[0], 0U);
    const CarryOver other = carry_over(job(43), job(42));
    EXPECT_EQ(other.engine.nodes[0], std::nullopt);
    EXPECT_EQ(other.leaving.nodes, std::vector<std::size_t>{0});
    EXPECT_EQ(other.leaving.outputs, std::vector<std::size_t>{0});
}

TEST(CarryOver, KeepsNoInputWhoseBytesMeanSomethingElse) {
    const CarryOver plan =
        carry_over(replaced(kJob, "[output.servos]", "slots = \"plain\"\n[output.servos]"));
    EXPECT_EQ(plan.engine.inputs[0].from, std::nullopt);
}

TEST(CarryOver, KeepsNoSensorBusNorItsValuesWhereATypeOfSensorChanged) {
    const std::string bus = "[sensor_bus.probes]\nrole = \"receiver\"\ndevice = \"/dev/ttyS\"\n";
    const auto lift = [](int id) {
        return "[sensor_type.lift]\nid = " + std::to_string(id) + "\n";
    };
    EXPECT_EQ(carry_over(kJob + bus + lift(133), kJob + bus + lift(133)).values.buses[0], 0U);
    EXPECT_EQ(carry_over(kJob + bus + lift(134), kJob + bus + lift(133)).values.buses[0],
              std::nullopt);
}

using Froms = std::vector<CarriedFrom>;

Froms inputs_of(const CarryOver& plan) {
    Froms from;
    for (const InputCarry& carry : plan.engine.inputs) {
        from.push_back(carry.from);
    }
    return from;
}

/// Inputs that read the same frames of a bus, under these names.
std::string alike_inputs(const std::vector<std::string>& names) {
    std::string text;
    std::string from;
    for (const std::string& name : names) {
        text += "[input." + name + "]\nprotocol = \"can\"\ninterface = \"can0\"\n";
        from += (from.empty() ? "\"" : ", \"") + name + "\"";
    }
    return text + "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n" +
           "[pipeline.main]\nfrom = [" + from + "]\nto = \"servos\"\n";
}

TEST(CarryOver, TakesTheInputOfTheNameBeforeOneThatIsAlike) {
    const auto from = [](const std::vector<std::string>& fresh,
                         const std::vector<std::string>& running) {
        return inputs_of(carry_over(alike_inputs(fresh), alike_inputs(running)));
    };
    EXPECT_EQ(from({"a", "b"}, {"b", "a"}), (Froms{1, 0}));
    EXPECT_EQ(from({"c", "b"}, {"b", "a"}), (Froms{1, 0})) << "what is left for a new name";
    EXPECT_EQ(from({"b", "c"}, {"b", "a"}), (Froms{0, 1}));
    EXPECT_EQ(from({"c", "d"}, {"a", "b"}), (Froms{0, 1}));
    EXPECT_EQ(from({"a", "b", "c"}, {"c"}), (Froms{std::nullopt, std::nullopt, 0}));
}

TEST(CarryOver, KeepsAnInputOrOutputThatWasOnlyRenamed) {
    const CarryOver plan = carry_over(replaced(
        replaced(replaced(replaced(kJob, "[input.receiver]", "[input.r]"), "\"receiver\"", "\"r\""),
                 "[output.servos]", "[output.s]"),
        "\"servos\"", "\"s\""));
    EXPECT_EQ(inputs_of(plan), Froms{0});
    EXPECT_EQ(plan.engine.outputs[0].from, 0U);
    EXPECT_TRUE(plan.engine.outputs[0].same_failsafe);
    EXPECT_TRUE(plan.leaving.empty());
}

TEST(CarryOver, DependsOnTheLineOfAnInputAndNotOnThatOfAnOutput) {
    const auto with = [](std::string_view at, const std::string& line) {
        return replaced(kJob, at, line + "\n" + std::string(at));
    };
    EXPECT_EQ(inputs_of(carry_over(with("[output.servos]", "baud = 57600"))), Froms{std::nullopt});
    for (const std::string line : {"baud = 200000", "scale = \"futaba\""}) {
        EXPECT_EQ(carry_over(with("[pipeline.main]", line)).engine.outputs[0].from, 0U) << line;
    }
    EXPECT_EQ(carry_over(replaced(kJob, "/dev/ttyB", "/dev/ttyC")).engine.outputs[0].from,
              std::nullopt);
}

TEST(CarryOver, DependsOnTheIdsOfAnOutputOnCan) {
    const auto job = [](const std::string& line) {
        return replaced(kJob, "protocol = \"sbus\"\ndevice = \"/dev/ttyB\"",
                        "protocol = \"can\"\ninterface = \"can0\"\n" + line);
    };
    EXPECT_EQ(carry_over(job("period = \"20ms\""), job("")).engine.outputs[0].from, 0U);
    EXPECT_EQ(carry_over(job("id = 0x400"), job("")).engine.outputs[0].from, std::nullopt);
}

TEST(CarryOver, TellsWhetherTheMapOfAnInputIsTheSame) {
    const std::string map = "[input.receiver.map]\n1 = 2\n";
    EXPECT_TRUE(carry_over(kJob + map, kJob + map).engine.inputs[0].same_channels);
    EXPECT_FALSE(carry_over(kJob + map, kJob).engine.inputs[0].same_channels);
    EXPECT_FALSE(carry_over(kJob).engine.inputs[0].new_keys);
    const auto other = carry_over(replaced(kJob, "/dev/ttyA", "/dev/ttyC")).engine.inputs[0];
    EXPECT_FALSE(other.same_channels);
    EXPECT_FALSE(other.new_keys);
}

/// Two outputs of one pipeline with failsafes of their own, and one of another pipeline.
std::string three_outputs(const std::string& to, const std::string& more = "") {
    const auto output = [](const std::string& name, const std::string& device) {
        return "[output." + name + "]\nprotocol = \"sbus\"\ndevice = \"" + device + "\"\n";
    };
    return "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n" +
           output("servos", "/dev/ttyB") + output("tail", "/dev/ttyC") +
           output("lamp", "/dev/ttyD") + "[pipeline.main]\nfrom = \"receiver\"\nto = " + to +
           "\n[pipeline.main.failsafe.output.servos]\nhold = \"1s\"\n"
           "[pipeline.main.failsafe.output.tail]\nhold = \"2s\"\n"
           "[pipeline.second]\nfrom = \"receiver\"\nto = \"lamp\"\n" +
           more;
}

TEST(CarryOver, ComparesTheFailsafeOfEachOutputWhereverItStands) {
    const std::string running = three_outputs("[\"servos\", \"tail\"]");
    const CarryOver plan = carry_over(three_outputs("[\"tail\", \"servos\"]"), running);
    ASSERT_EQ(plan.engine.outputs.size(), 3U);
    for (const OutputCarry& carry : plan.engine.outputs) {
        EXPECT_TRUE(carry.same_failsafe);
        EXPECT_TRUE(carry.same_channels);
        EXPECT_TRUE(carry.same_schedule);
    }
    const auto changed = carry_over(
        three_outputs("[\"servos\", \"tail\"]",
                      "[pipeline.second.failsafe]\nhold = \"2s\"\n[pipeline.second.channels]\n"
                      "1 = 2\n"),
        running);
    EXPECT_TRUE(changed.engine.outputs[0].same_failsafe);
    EXPECT_TRUE(changed.engine.outputs[1].same_channels);
    EXPECT_FALSE(changed.engine.outputs[2].same_failsafe);
    EXPECT_FALSE(changed.engine.outputs[2].same_channels);
    EXPECT_TRUE(changed.engine.outputs[2].same_schedule);
}

TEST(CarryOver, WithoutAPipelineAnOutputHasNeitherMapNorFailsafe) {
    const std::string job = kJob +
                            "[values.cells]\nconstant = 6\n"
                            "[output.o]\nprotocol = \"crsf-telemetry\"\ndevice = \"/dev/ttyC\"\n"
                            "battery = { voltage = \"cells\" }\n";
    const CarryOver plan = carry_over(job, job);
    ASSERT_EQ(plan.engine.outputs.size(), 2U);
    EXPECT_EQ(plan.engine.outputs[1].from, 1U);
    EXPECT_TRUE(plan.engine.outputs[1].same_schedule);
    EXPECT_FALSE(plan.engine.outputs[1].same_channels);
    EXPECT_FALSE(plan.engine.outputs[1].same_failsafe);
}

TEST(CarryOver, NamesTheOutputsThatLeave) {
    const CarryOver plan = carry_over(kJob, three_outputs("[\"servos\", \"tail\"]"));
    EXPECT_EQ(plan.leaving.outputs, (std::vector<std::size_t>{1, 2}));
    EXPECT_FALSE(plan.leaving.empty());
}

TEST(CarryOver, NamesEachObstacleByItself) {
    const std::string scheduling = "[runtime] changes the scheduling of the data thread";
    for (const std::string line : {"priority = 70", "cpu = 1", "realtime = \"off\""}) {
        EXPECT_EQ(carry_over(kJob + "[runtime]\n" + line + "\n").obstacles,
                  std::vector<std::string>{scheduling})
            << line;
    }
    const std::string lamp = "[gpio.lamp]\nline = \"GPIO17\"\nrole = \"link\"\n";
    const std::string released =
        "the GPIO lines have changed, and the program must release the old ones first";
    EXPECT_EQ(carry_over(kJob + lamp).obstacles, std::vector<std::string>{released});
    EXPECT_EQ(carry_over(kJob, kJob + lamp).obstacles, std::vector<std::string>{released});
    EXPECT_EQ(carry_over(kJob + "[runtime]\ncpu = 1\n" + lamp).obstacles,
              (std::vector<std::string>{scheduling, released}));
    const std::string renamed =
        replaced(replaced(kJob, "[input.receiver]", "[input.r]"), "\"receiver\"", "\"r\"");
    EXPECT_EQ(carry_over(renamed + lamp, kJob + lamp).obstacles,
              std::vector<std::string>{
                  "inputs or outputs that GPIO lines refer to were added or removed"});
    EXPECT_TRUE(carry_over(renamed).obstacles.empty());
}

std::string node_job(const std::string& lines, const std::string& interface = "can0") {
    return kJob + "[dronecan.n]\ninterface = \"" + interface + "\"\n" + lines + "\n";
}

TEST(CarryOver, KeepsNoNodeThatOthersWouldTakeForAnotherOne) {
    const std::string running = node_job("node_id = 7\nname = \"a\"");
    const auto from = [&](const std::string& fresh) {
        return carry_over(fresh, running).engine.nodes.at(0);
    };
    EXPECT_EQ(from(running), 0U);
    EXPECT_EQ(from(running + "allow_restart = true\n"), 0U);
    EXPECT_EQ(from(node_job("node_id = 8\nname = \"a\"")), std::nullopt);
    EXPECT_EQ(from(node_job("node_id = 7\nname = \"b\"")), std::nullopt);
    EXPECT_EQ(from(node_job("node_id = 7\nname = \"a\"\ndynamic = true")), std::nullopt);
    EXPECT_EQ(from(node_job("node_id = 7\nname = \"a\"", "can1")), std::nullopt);
    Configuration elsewhere = loaded(running);
    elsewhere.file = "other.toml";
    EXPECT_EQ(plan_carry_over(loaded(running), elsewhere).engine.nodes.at(0), std::nullopt);
}

TEST(CarryOver, TakesTheNodeOfTheInterfaceWhateverTheOrder) {
    const std::string first = "[dronecan.x]\ninterface = \"can1\"\nnode_id = 8\n";
    const std::string second = "[dronecan.y]\ninterface = \"can2\"\nnode_id = 9\n";
    const CarryOver plan = carry_over(kJob + second + first, kJob + first + second);
    EXPECT_EQ(plan.engine.nodes, (Froms{1, 0}));
    EXPECT_EQ(carry_over(kJob + second, kJob + first + second).leaving.nodes,
              std::vector<std::size_t>{0});
}

}  // namespace
}  // namespace tribus::test::carry_over_test
