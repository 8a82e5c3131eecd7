#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "tests/unit/config/main_job.h"

/// Detectors of an input, and mistakes in their settings.
namespace tribus::test::supervision_test {
namespace {

using std::chrono::milliseconds;

SupervisionSettings supervision_of(const std::string& input_lines) {
    const auto configuration = load_configuration(main_job_with(3, input_lines), "t.toml");
    return configuration ? configuration->inputs.at(0).supervision : SupervisionSettings{};
}
std::string sbus_with(std::string_view line) {
    std::string text = main_job_with(2, "protocol = \"sbus\"");
    const std::string device = "device = \"/dev/ttyA\"";
    return text.replace(text.find(device), device.size(), device + "\n" + std::string(line));
}

TEST(Supervision, ReadsEveryDetectorForSbus) {
    const auto configuration = load_configuration(sbus_with(R"(timeout = "50ms"
failsafe_flag = false
frame_lost_flag = false
frame_lost_run = "2s"
frame_lost_ratio = 1
frozen = "10s"
plausible = [900, 2100]
zero_guard = "0s"
failsafe_when = [{ all_zero = true }, { channel = 3, between = [985, 995] }])"),
                                                  "t.toml");
    ASSERT_TRUE(configuration) << format_mistake(configuration.error().front());
    const SupervisionSettings& supervision = configuration->inputs[0].supervision;
    EXPECT_EQ(supervision.timeout, milliseconds(50));
    EXPECT_FALSE(supervision.failsafe_flag);
    EXPECT_FALSE(supervision.frame_lost_flag);
    EXPECT_EQ(supervision.frame_lost_run, Duration(milliseconds(2000)));
    EXPECT_EQ(supervision.frame_lost_ratio, 1);
    EXPECT_EQ(supervision.frozen, milliseconds(10000));
    ASSERT_TRUE(supervision.plausible);
    EXPECT_EQ(supervision.plausible->low, Pulse::from_microseconds(900));
    EXPECT_EQ(supervision.plausible->high, Pulse::from_microseconds(2100));
    EXPECT_EQ(supervision.zero_guard, Duration::zero());
    ASSERT_EQ(supervision.failsafe_when.size(), 2U);
    EXPECT_TRUE(supervision.failsafe_when[0].all_zero);
    EXPECT_EQ(supervision.failsafe_when[1].channel, 2U);
    ASSERT_TRUE(supervision.failsafe_when[1].between);
    EXPECT_EQ(supervision.failsafe_when[1].between->low, Pulse::from_microseconds(985));
    EXPECT_EQ(supervision.failsafe_when[1].between->high, Pulse::from_microseconds(995));
}

TEST(Supervision, KnowsWhatARawZeroReadsInTheScaleOfTheInput) {
    const auto zero_with = [](std::string_view scale) {
        const auto configuration = load_configuration(sbus_with(scale), "t.toml");
        return configuration ? configuration->inputs.at(0).supervision.raw_zero : std::nullopt;
    };
    EXPECT_EQ(zero_with("scale = \"betaflight\""), Pulse::from_microseconds(880));
    EXPECT_EQ(zero_with("scale = { raw = [0, 2000], us = [900, 2100] }"),
              Pulse::from_microseconds(900));
    EXPECT_FALSE(supervision_of("device = \"/dev/ttyA\"").raw_zero) << "i.Bus has none";
}

TEST(Supervision, HasAMapOfItsOwnForAnInput) {
    const auto configuration = load_configuration(
        main_job_with(3, "device = \"/dev/ttyA\"\n[input.receiver.map]\n3 = 1"), "t.toml");
    ASSERT_TRUE(configuration);
    ASSERT_EQ(configuration->inputs[0].channels.size(), 1U);
    EXPECT_EQ(configuration->inputs[0].channels[0].output, 2U);
}

TEST(Supervision, MissesChannelsAfterTheTimeout) {
    EXPECT_EQ(supervision_of("device = \"/dev/ttyA\"\ntimeout = \"50ms\"").fewer_channels_after,
              milliseconds(50));
    EXPECT_EQ(supervision_of("device = \"/dev/ttyA\"").fewer_channels_after, milliseconds(100));
}

class MistakeInSupervision : public ::testing::TestWithParam<Spoilt> {};

TEST_P(MistakeInSupervision, IsReportedWithItsPlaceAndWhatIsAllowed) {
    const Spoilt& spoilt = GetParam();
    const auto mistakes = mistakes_in(main_job_with(spoilt.line, spoilt.replacement));
    EXPECT_EQ(mistakes, std::vector<std::string>{std::string(spoilt.expected)});
}

constexpr Spoilt kMistakes[]{
    {"a_flag_of_a_wire_that_has_none", 3,
     R"(device = "/dev/ttyA"
failsafe_flag = true)",
     R"(t.toml:4:1: "failsafe_flag" has no effect: "ibus" cannot mark a frame as lost; use )"
     R"("failsafe_when" or "frozen" to detect what its receivers do instead)"},
    {"a_zero_guard_where_zero_means_nothing", 3,
     R"(device = "/dev/ttyA"
zero_guard = "1s")",
     R"(t.toml:4:1: "zero_guard" has no effect: "ibus" has no zero that means "no value"; )"
     R"(allowed with "sbus")"},
    {"all_zero_where_zero_means_nothing", 3,
     R"(device = "/dev/ttyA"
failsafe_when = [{ all_zero = true }])",
     R"(t.toml:4:18: "all_zero" has no effect: "ibus" has no zero that means "no value"; )"
     R"(allowed with "sbus")"},
    {"all_zero_beside_a_channel", 2,
     R"(protocol = "sbus"
failsafe_when = [{ all_zero = true, channel = 3 }])",
     R"(t.toml:3:31: "all_zero" applies to all channels; a rule with it has no other key)"},
    {"a_range_that_is_the_wrong_way_round", 3,
     R"(device = "/dev/ttyA"
plausible = [2100, 900])",
     R"(t.toml:4:13: "plausible" is [2100, 900]; the lower number comes first: plausible = [900, )"
     R"(2100])"},
    {"a_range_of_one_number", 3,
     R"(device = "/dev/ttyA"
failsafe_when = [{ channel = 3, between = 900 }])",
     R"(t.toml:4:43: "between" is 900; allowed: two numbers of microseconds from 0 to 4095, )"
     R"(the lower one first: [985, 995])"},
    {"a_map_that_is_no_table", 3,
     R"(device = "/dev/ttyA"
map = 3)",
     R"(t.toml:4:7: [input.receiver.map] is 3; allowed: a table, such as { 1 = 2 })"},
};

INSTANTIATE_TEST_SUITE_P(Mistakes, MistakeInSupervision, ::testing::ValuesIn(kMistakes),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace tribus::test::supervision_test
