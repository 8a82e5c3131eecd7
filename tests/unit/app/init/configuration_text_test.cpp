#include "app/init/configuration_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <optional>
#include <regex>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "config/keys/keys.h"
#include "config/language/mistakes.h"
#include "config/load.h"
#include "tests/unit/app/init/examined_places.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/sbus/sbus.h"

namespace tribus::init::test::configuration_text_test {
namespace {

ExaminedPlace port_of(const Protocol& protocol, const std::string& number) {
    return protocol.shape == WireShape::bytes ? free_port(number) : interface_named("can" + number);
}
Attachment input_of(const Protocol& protocol, const std::string& number = "0") {
    return decide_input(port_of(protocol, number), &protocol).attachment.value();
}
Attachment output_of(const Protocol& protocol, const std::string& number = "1") {
    return decide_output(port_of(protocol, number), &protocol, "").attachment.value();
}
Attachment heard_input(const doctor::LineStory& story) {
    return decide_input(with_story(free_port("0"), story), nullptr).attachment.value();
}

Configuration loaded(const std::string& text) {
    auto configuration = load_configuration(text, "init.toml");
    if (!configuration) {
        for (const Mistake& mistake : configuration.error()) {
            ADD_FAILURE() << format_mistake(mistake);
        }
        ADD_FAILURE() << text;
        return {};
    }
    return *configuration;
}

/// The text with every proposed key uncommented.
std::string with_proposed_keys(const std::string& text) {
    static const std::regex proposed(R"(^# (\[[a-z.]+\]|[a-z0-9_]+ = .*)$)");
    std::istringstream lines(text);
    std::string result;
    for (std::string line; std::getline(lines, line);) {
        result += std::regex_replace(line, proposed, "$1") + "\n";
    }
    EXPECT_NE(result, text);
    return result;
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

Plan plan_of(const Attachment& input, const Attachment& output) {
    return {.inputs = {input}, .outputs = {output}};
}

TEST(InitText, IsAConfigurationForEachPairOfProtocols) {
    std::size_t tried = 0;
    for (const Protocol* in : offered_protocols(SettingScope::input)) {
        for (const Protocol* out : offered_protocols(SettingScope::output)) {
            const Configuration made =
                loaded(configuration_text(plan_of(input_of(*in), output_of(*out)), "rc.toml"));
            ASSERT_EQ(made.inputs.size(), 1U);
            ASSERT_EQ(made.outputs.size(), 1U);
            EXPECT_EQ(made.inputs[0].protocol, in);
            EXPECT_EQ(made.inputs[0].port.device, port_of(*in, "0").name);
            EXPECT_EQ(made.outputs[0].protocol, out);
            EXPECT_EQ(made.outputs[0].port.device, port_of(*out, "1").name);
            EXPECT_EQ(made.pipelines.size(), 1U);
            ++tried;
        }
    }
    EXPECT_GE(tried, 16U);
}

/// Inputs with every protocol, and with every combination of what can be heard.
std::vector<Attachment> all_inputs() {
    std::vector<Attachment> inputs;
    for (const Protocol* protocol : offered_protocols(SettingScope::input)) {
        inputs.push_back(input_of(*protocol));
    }
    std::vector<std::string_view> scales{""};
    for (const Setting& setting : kSbusProtocol.settings) {
        if (setting.key == "scale") {
            scales.insert(scales.end(), setting.choices.begin(), setting.choices.end());
        }
    }
    EXPECT_GT(scales.size(), 2U);
    using std::chrono::milliseconds;
    for (const std::optional<Duration> period :
         {std::optional<Duration>(), {milliseconds(7)}, {milliseconds(80)}, {milliseconds(2900)}}) {
        for (const std::size_t channels : {6U, 14U, 18U}) {
            doctor::LineStory story = heard_ibus(channels);
            story.period = period;
            inputs.push_back(heard_input(story));
        }
        for (const LineSettings& line : {doctor::kSbusLine, doctor::kFastSbusLine}) {
            for (const std::string_view scale : scales) {
                doctor::LineStory story = heard_sbus();
                story.line = line;
                story.scale = {std::string(scale), "the sticks rest at its centre"};
                story.period = period;
                inputs.push_back(heard_input(story));
            }
        }
    }
    return inputs;
}

/// Every set of at most `most` outputs with different protocols, and all of them.
std::vector<std::vector<Attachment>> sets_of_outputs(std::size_t most) {
    const auto offered = offered_protocols(SettingScope::output);
    std::vector<std::vector<Attachment>> sets;
    for (std::size_t bits = 1; bits < (std::size_t{1} << offered.size()); ++bits) {
        std::vector<Attachment> outputs;
        for (std::size_t i = 0; i < offered.size(); ++i) {
            if ((bits >> i & 1U) != 0) {
                outputs.push_back(output_of(*offered[i], std::to_string(i + 2)));
            }
        }
        if (outputs.size() <= most || outputs.size() == offered.size()) {
            sets.push_back(outputs);
        }
    }
    return sets;
}

void expect_configurations_for_all_inputs(std::size_t most_outputs) {
    const std::vector<double> throttles{kLeastPulse, kLowThrottleUs, 1500.125, kMostPulse};
    std::size_t tried = 0;
    for (const Attachment& input : all_inputs()) {
        for (const std::vector<Attachment>& outputs : sets_of_outputs(most_outputs)) {
            const Plan plan{.inputs = {input, input_of(kIbusProtocol, "99")},
                            .outputs = outputs,
                            .throttle_us = throttles[tried++ % throttles.size()]};
            const Configuration made = loaded(configuration_text(plan, "rc.toml"));
            ASSERT_EQ(made.inputs.size(), 2U);
            EXPECT_EQ(made.inputs[0].protocol, input.protocol);
            ASSERT_EQ(made.outputs.size(), outputs.size());
            ASSERT_EQ(made.pipelines.size(), 1U);
        }
    }
    EXPECT_GT(tried, 500U);
}

TEST(InitText, IsAConfigurationForEverythingThatCanBeHeardAndEveryPairOfOutputs) {
    expect_configurations_for_all_inputs(2);
}

/// Each further protocol doubles their number.
TEST(InitTextOfEverySet, IsAConfigurationForEverythingThatCanBeHeard) {
    expect_configurations_for_all_inputs(offered_protocols(SettingScope::output).size());
}

TEST(InitText, IsAConfigurationWithTheProposedKeysUncommented) {
    for (const Protocol* in : offered_protocols(SettingScope::input)) {
        for (const Protocol* out : offered_protocols(SettingScope::output)) {
            Plan plan = plan_of(input_of(*in), output_of(*out));
            plan.inputs[0].channels = 18;
            const Configuration made =
                loaded(with_proposed_keys(configuration_text(plan, "rc.toml")));
            ASSERT_EQ(made.inputs.size(), 1U);
            EXPECT_EQ(made.inputs[0].supervision.failsafe_when.size(), 1U);
        }
    }
}

/// Two inputs of each of these protocols, and two outputs of every protocol.
void expect_all_held(std::span<const Protocol* const> protocols) {
    std::vector<Attachment> inputs;
    std::vector<Attachment> outputs;
    int number = 0;
    for (const Protocol* in : protocols) {
        inputs.push_back(input_of(*in, std::to_string(number++)));
        inputs.push_back(input_of(*in, std::to_string(number++)));
    }
    for (const Protocol* out : offered_protocols(SettingScope::output)) {
        outputs.push_back(output_of(*out, std::to_string(number++)));
        outputs.push_back(output_of(*out, std::to_string(number++)));
    }
    const Plan plan{.inputs = inputs, .outputs = outputs};
    const Configuration made = loaded(configuration_text(plan, "rc.toml"));
    EXPECT_EQ(made.inputs.size(), inputs.size());
    EXPECT_EQ(made.outputs.size(), outputs.size());
    const std::string name = protocols[0]->shape == WireShape::bytes ? "receiver" : "bus";
    EXPECT_EQ(input_names(plan)[0], name);
    EXPECT_EQ(input_names(plan)[1], name + "2");
}

TEST(InitText, HoldsSeveralInputsAndOutputs) {
    const auto offered = offered_protocols(SettingScope::input);
    constexpr std::size_t kAtOnce = kMostPipelineInputs / 2;
    for (std::size_t first = 0; first < offered.size(); first += kAtOnce) {
        const std::size_t count = std::min(kAtOnce, offered.size() - first);
        expect_all_held(std::span(offered).subspan(first, count));
    }
}

TEST(InitText, HoldsWhatWasHeard) {
    doctor::LineStory story = heard_sbus();
    story.line = doctor::kFastSbusLine;
    story.scale = {"futaba", "the sticks rest at 1024"};
    story.period = std::chrono::milliseconds(80);
    const std::string text =
        configuration_text(plan_of(heard_input(story), output_of(kIbusProtocol)), "rc.toml");
    EXPECT_TRUE(has(text, "# Heard: SBUS, 16 channels and 2 switches, 200000 baud 8E2")) << text;
    EXPECT_TRUE(has(text, "# Scale: the sticks rest at 1024")) << text;
    const Configuration made = loaded(text);
    ASSERT_EQ(made.inputs.size(), 1U);
    EXPECT_EQ(made.inputs[0].port.line.baud, 200'000U);
    EXPECT_EQ(made.inputs[0].supervision.timeout, std::chrono::milliseconds(240));
    EXPECT_EQ(made.inputs[0].settings.get_or<std::string>("scale", ""), "futaba");
}

TEST(InitText, SaysWhichChannelsAReceiverOf14ChannelsDoesNotSend) {
    const auto text_for = [](std::size_t channels) {
        return configuration_text(
            plan_of(heard_input(heard_ibus(channels)), output_of(kSbusProtocol)), "rc.toml");
    };
    EXPECT_TRUE(has(text_for(14), "# The receiver sends 14 channels."));
    EXPECT_FALSE(has(text_for(18), "# The receiver sends"));
}

TEST(InitText, SendsPresetsIfTheProtocolHasAMarkForFailsafe) {
    Plan plan = plan_of(input_of(kIbusProtocol), output_of(kSbusProtocol));
    plan.throttle_us = 1500;
    EXPECT_TRUE(sends_presets(plan));
    const Configuration made = loaded(configuration_text(plan, "rc.toml"));
    ASSERT_EQ(made.pipelines.size(), 1U);
    const FailsafeSettings& failsafe = made.pipelines[0].failsafe[0];
    EXPECT_EQ(failsafe.action, FailsafeAction::preset);
    EXPECT_EQ(failsafe.presets[2].microseconds(), 1500);
    EXPECT_EQ(failsafe.hold, std::chrono::milliseconds(300));
}

TEST(InitText, FallsSilentIfTheProtocolHasNoMarkForFailsafe) {
    Plan plan = plan_of(input_of(kSbusProtocol), output_of(kIbusProtocol));
    EXPECT_FALSE(sends_presets(plan));
    const Configuration alone = loaded(configuration_text(plan, "rc.toml"));
    ASSERT_EQ(alone.pipelines.size(), 1U);
    EXPECT_EQ(alone.pipelines[0].failsafe[0].action, FailsafeAction::silence);

    plan.outputs.push_back(output_of(kSbusProtocol, "2"));
    EXPECT_TRUE(sends_presets(plan));
    const Configuration both = loaded(configuration_text(plan, "rc.toml"));
    ASSERT_EQ(both.pipelines.size(), 1U);
    EXPECT_EQ(both.pipelines[0].failsafe[0].action, FailsafeAction::silence);
    EXPECT_EQ(both.pipelines[0].failsafe[1].action, FailsafeAction::preset);
}

/// Names come from the command line and may hold anything that a file name may.
TEST(InitText, AsksForASafePresetFirstOnlyIfOneIsSent) {
    const std::string step = "\n# - Set `preset` at the end to what is safe on your machine.\n";
    EXPECT_TRUE(has(
        configuration_text(plan_of(input_of(kIbusProtocol), output_of(kSbusProtocol)), "rc.toml"),
        step));
    EXPECT_FALSE(has(
        configuration_text(plan_of(input_of(kSbusProtocol), output_of(kIbusProtocol)), "rc.toml"),
        step));
}

TEST(InitText, KeepsNamesOutOfCommentsThatWouldBreakThem) {
    Plan plan = plan_of(input_of(kIbusProtocol), output_of(kSbusProtocol));
    plan.inputs[0].node = "/dev/\n[runtime]\ncpu = 99";
    plan.inputs[0].name = "/dev/\"quoted\" # 1";
    const Configuration made = loaded(configuration_text(plan, "a\nb = 1\n.toml"));
    ASSERT_EQ(made.inputs.size(), 1U);
    EXPECT_EQ(made.inputs[0].port.device, "/dev/\"quoted\" # 1");
    EXPECT_FALSE(made.runtime.cpu);
}

TEST(InitText, KeepsTo80Columns) {
    for (const Protocol* out : offered_protocols(SettingScope::output)) {
        std::istringstream lines(
            configuration_text(plan_of(heard_input(heard_ibus(18)), output_of(*out)), "rc.toml"));
        for (std::string line; std::getline(lines, line);) {
            EXPECT_LE(line.size(), 80U) << line;
        }
    }
}

}  // namespace
}  // namespace tribus::init::test::configuration_text_test
