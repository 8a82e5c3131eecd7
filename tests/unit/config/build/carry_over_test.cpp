#include "config/build/carry_over.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

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

}  // namespace
}  // namespace tribus::test::carry_over_test
