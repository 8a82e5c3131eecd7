#include <gtest/gtest.h>

#include "config/show/effective.h"
#include "tests/unit/config/examples.h"
#include "tests/unit/config/main_job.h"

namespace tribus::test::examples_test {
namespace {

TEST(Examples, AllAreValid) {
    const ExamplesWithKeys examples;
    EXPECT_GE(examples.files().size(), 22U);
    for (const auto& file : examples.files()) {
        EXPECT_EQ(mistakes_in(content_of(file), file.string()), std::vector<std::string>{}) << file;
    }
}

TEST(Examples, NameTheSchemaForEditorsInTheirFirstLine) {
    for (const auto& file : example_files()) {
        EXPECT_TRUE(content_of(file).starts_with("#:schema ../tribus.schema.json\n")) << file;
    }
}

TEST(EffectiveConfiguration, IsValidInputThatMeansTheSame) {
    const ExamplesWithKeys examples;
    for (const auto& file : examples.files()) {
        const auto first = load_configuration_file(file);
        ASSERT_TRUE(first) << file;
        const std::string text = effective_toml(*first);
        EXPECT_EQ(mistakes_in(text, file.string()), std::vector<std::string>{}) << text;
        const auto second = load_configuration(text, file.string());
        ASSERT_TRUE(second) << file;
        EXPECT_EQ(effective_toml(*second), text) << file;
        EXPECT_EQ(effective_json(*second), effective_json(*first)) << file;
    }
}

TEST(EffectiveConfiguration, ShowsEveryDefaultOfTheNineLines) {
    const auto configuration = load_configuration(main_job_with(0, ""), "t.toml");
    ASSERT_TRUE(configuration);
    EXPECT_EQ(effective_toml(*configuration), R"([runtime]
realtime = "auto"
priority = 80
spin = "0s"

[input.receiver]
protocol = "ibus"
device = "/dev/ttyA"
timeout = "100ms"
frozen = "0s"
plausible = [800, 2200]
failsafe_when = []
baud = 115200
slots = "nibbles"

[output.servos]
protocol = "sbus"
device = "/dev/ttyB"
period = "14ms"
force = false
schedule = "follow"
phase = "free"
baud = 100000
scale = "betaflight"
inverted = false

[pipeline.main]
from = ["receiver"]
to = ["servos"]
mode = "priority"

[pipeline.main.failsafe.output.servos]
hold = "300ms"
action = "preset"
recover = "500ms"
power_on = "500ms"
preset = { 3 = 988, other = 1500 }
)");
}

TEST(EffectiveConfiguration, KeepsAllThatAFileCanSay) {
    const std::string text = R"([runtime]
realtime = "require"
priority = 50
cpu = 3

[input.a]
protocol = "sbus"
device = "/dev/\"quoted\" \\"
timeout = "1500us"
)";
    const auto wrong = load_configuration(text, "t.toml");
    EXPECT_FALSE(wrong) << "1.5 ms is below the least timeout";

    const std::string all = R"([runtime]
realtime = "require"
priority = 50
cpu = 3
spin = "60us"

[input.a]
protocol = "sbus"
device = "/dev/\"quoted\" \\"
timeout = "20500us"
failsafe_flag = false
frame_lost_flag = false
frame_lost_run = "2s"
frame_lost_ratio = 0.5
frozen = "10s"
plausible = [880.5, 2159]
zero_guard = "2s"
failsafe_when = [{ channel = 4, above = 2100.125, between = [1, 2] }, { all_zero = true }]
baud = 200000
scale = { raw = [172, 1811], us = [988.5, 2012] }
inverted = false

[input.a.map]
1 = 2
2 = { mix = { 1 = 1.02 }, reverse = false, trim = 0, expo = 0, deadband = 0 }

[input.c]
protocol = "sbus"
device = "/dev/ttyC"
timeout = "100ms"
failsafe_flag = true
frame_lost_flag = true
frame_lost_run = "100ms"
frame_lost_ratio = 0.9
frozen = "0s"
plausible = [800, 2200]
zero_guard = "1s"
failsafe_when = []
baud = 100000
scale = "betaflight"
inverted = false

[input.d]
protocol = "ibus"
device = "/dev/ttyD"
timeout = "100ms"
frozen = "0s"
plausible = [800, 2200]
failsafe_when = []
baud = 115200
slots = "nibbles"

[output.b]
protocol = "sbus"
device = "/dev/ttyB"
period = "6ms"
force = true
schedule = "grid"
phase = "locked"
baud = 100000
scale = "px4"
inverted = false

[pipeline.p]
from = ["a", "c", "d"]
to = ["b"]
mode = "median"
tolerance = 40
changeover = "2000us/s"

[pipeline.p.handover]
input = "c"
channel = 8

[pipeline.p.channels]
1 = 2
2 = { from = 1, reverse = true, trim = -12.5, expo = 0.3, deadband = 4, min = 1100, max = 1900 }
3 = { mix = { 1 = 0.5, 2 = -1 }, reverse = false, trim = 0, expo = 0, deadband = 0 }
4 = { from = 4, reverse = false, trim = 0, expo = 0, deadband = 0, slew = "2000us/s" }
16 = { fixed = 1500.125 }
17 = { from = 9, above = 1700, below = 1200 }

[pipeline.p.failsafe.output.b]
hold = "0s"
action = "preset"
slew = "1000us/s"
recover = "2s"
power_on = "3s"
preset = { 1 = 1200, 18 = 2000, other = 1000.5 }

[pipeline.p.failsafe.output.b.release_when]
channel = 3
below = 1050
)";
    const auto configuration = load_configuration(all, "t.toml");
    ASSERT_TRUE(configuration) << format_mistake(configuration.error().front());
    EXPECT_EQ(effective_toml(*configuration), all);
}

}  // namespace
}  // namespace tribus::test::examples_test
