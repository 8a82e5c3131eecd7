#include "config/show/manual_sections.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "transports/registry/registry.h"

namespace tribus::test::manual_sections_test {
namespace {

using Texts = std::vector<std::string>;

ManualSection section(std::string_view title) {
    const auto all = manual_sections();
    const auto found = std::ranges::find(all, title, &ManualSection::title);
    EXPECT_NE(found, all.end()) << title;
    return found == all.end() ? ManualSection{} : *found;
}

Texts key_names(const ManualSection& section) {
    Texts names;
    for (const Key& key : section.keys) {
        names.emplace_back(key.name());
    }
    return names;
}

/// The sections of the protocols, with those of their trees.
bool is_of_protocol(const ManualSection& section) {
    return std::ranges::any_of(protocols(), [&](const Protocol* protocol) {
        return section.anchor == protocol->name ||
               section.anchor.starts_with(std::string(protocol->name) + "-");
    });
}

TEST(SectionsOfTheManual, AreInTheOrderOfTheFile) {
    Texts outline;
    for (const ManualSection& one : manual_sections()) {
        if (!is_of_protocol(one)) {
            outline.push_back(fmt::format("{}{} #{}{}", one.inner ? "- " : "", one.title,
                                          one.anchor, one.shows_scope ? " scopes" : ""));
        }
    }
    EXPECT_EQ(outline,
              (Texts{"The file #", "`[runtime]` #runtime", "`[input.NAME]` #input",
                     "- A rule of `failsafe_when` #failsafe_when", "`[output.NAME]` #output",
                     "Keys of protocols #", "`[pipeline.NAME]` #pipeline", "- `handover` #handover",
                     "`[pipeline.NAME.channels]`, `[input.NAME.map]` #channels",
                     "`[pipeline.NAME.failsafe]` #failsafe", "- `release_when` #release_when",
                     "`[gpio.NAME]` #gpio", "`[sensor_bus.NAME]` #sensor_bus",
                     "- `[[sensor_bus.NAME.sensor]]` #sensor", "`[sensor_type.NAME]` #sensor_type",
                     "`[values.NAME]` #values", "`[dronecan.NAME]` #dronecan_node",
                     "`[recorder]` #recorder"}));
}

TEST(SectionsOfTheManual, AreOneForEachProtocolWithChannels) {
    Texts titles;
    for (const ManualSection& one : manual_sections()) {
        if (is_of_protocol(one)) {
            EXPECT_TRUE(one.inner) << one.title;
            EXPECT_EQ(one.way, SettingScope::both) << one.title;
            if (one.shows_scope) {
                titles.push_back(one.title);
                EXPECT_EQ(one.title, "`" + one.anchor + "`");
            }
        }
    }
    Texts expected;
    for (const Protocol* protocol : protocols()) {
        if (protocol->make_decoder != nullptr || protocol->make_encoder != nullptr) {
            expected.push_back("`" + std::string(protocol->name) + "`");
        }
    }
    EXPECT_EQ(titles, expected);
    EXPECT_LT(titles.size(), protocols().size());
}

TEST(SectionsOfTheManual, HaveTheKeysOfEachTable) {
    const auto expect_keys = [](std::string_view title, std::span<const Key> keys) {
        Texts names;
        for (const Key& key : keys) {
            names.emplace_back(key.name());
        }
        EXPECT_EQ(key_names(section(title)), names) << title;
    };
    expect_keys("`[runtime]`", runtime_keys());
    expect_keys("A rule of `failsafe_when`", loss_rule_keys());
    expect_keys("`[pipeline.NAME]`", pipeline_keys());
    expect_keys("`handover`", handover_keys());
    expect_keys("`[pipeline.NAME.channels]`, `[input.NAME.map]`", channel_keys());
    expect_keys("`[pipeline.NAME.failsafe]`", failsafe_keys());
    expect_keys("`release_when`", release_rule_keys());
    expect_keys("`[gpio.NAME]`", line_keys());
    expect_keys("`[sensor_bus.NAME]`", sensor_bus_keys());
    expect_keys("`[[sensor_bus.NAME.sensor]]`", sensor_keys());
    expect_keys("`[sensor_type.NAME]`", sensor_type_keys());
    expect_keys("`[values.NAME]`", values_keys());
    expect_keys("`[dronecan.NAME]`", dronecan_keys());
    expect_keys("`[recorder]`", recorder_keys());
}

TEST(SectionsOfTheManual, HaveTheKeysOfAllMediaOfInputsAndOutputs) {
    const ManualSection input = section("`[input.NAME]`");
    EXPECT_EQ(input.way, SettingScope::input);
    EXPECT_EQ(key_names(input), (Texts{"protocol",
                                       "device",
                                       "address",
                                       "spi",
                                       "line",
                                       "interface",
                                       "timeout",
                                       "failsafe_flag",
                                       "frame_lost_flag",
                                       "frame_lost_run",
                                       "frame_lost_ratio",
                                       "failsafe_when",
                                       "frozen",
                                       "plausible",
                                       "zero_guard",
                                       "map",
                                       "public",
                                       "sender",
                                       "grab",
                                       "edge",
                                       "bias"}));
    const ManualSection output = section("`[output.NAME]`");
    EXPECT_EQ(output.way, SettingScope::output);
    EXPECT_EQ(key_names(output),
              (Texts{"protocol", "device", "address", "spi", "name", "chip", "line", "interface",
                     "period", "force", "schedule", "phase", "public", "output_enable",
                     "calibration", "foreign_sender"}));
}

TEST(SectionsOfTheManual, TellWhereAPlaceIsRequired) {
    const ManualSection input = section("`[input.NAME]`");
    for (const auto& [name, absent] : std::vector<std::pair<std::string, std::string>>{
             {"device", "required on a serial line"}, {"interface", "required on CAN"}}) {
        const Key& key = key_named(input.keys, name);
        EXPECT_FALSE(key.setting.required) << name;
        EXPECT_EQ(key.setting.absent, absent);
    }
    const std::string help(key_named(input.keys, "device").setting.help);
    EXPECT_TRUE(help.starts_with("Serial device, such as ")) << help;
    EXPECT_NE(help.find("; on an input device: "), std::string::npos) << help;
    const std::string of_output(key_named(section("`[output.NAME]`").keys, "device").setting.help);
    EXPECT_EQ(of_output.find("; on "), std::string::npos) << of_output;
}

TEST(SectionsOfTheManual, NameTheKeyOfEachMedium) {
    const std::string input = section("`[input.NAME]`").text;
    const std::string output = section("`[output.NAME]`").text;
    for (const std::string part :
         {"One key names the place: `device` on a serial line (`ibus`, `sbus`, ",
          ", `mavlink`), or `address` on UDP (`ibus`, ",
          "), or `device` on an input device (`gamepad`), or",
          "or `line` on a pulse line (`ppm`), or `interface` on CAN (`can`, `dbc`, `dronecan`). "
          "Each protocol has [keys of its own](#keys-of-protocols) besides."}) {
        EXPECT_NE(input.find(part), std::string::npos) << part;
    }
    for (const std::string part :
         {"or `name` on a virtual joystick (`joystick`), or `chip` on a PWM chip (`pwm`), or "
          "`line` on a pulse line (`ppm`), or `interface` on CAN (`can`, `dbc`, `sensors`, "
          "`dronecan`). Each"}) {
        EXPECT_NE(output.find(part), std::string::npos) << part;
    }
    EXPECT_EQ(input.find("joystick"), std::string::npos);
    EXPECT_EQ(output.find("gamepad"), std::string::npos);
}

struct Told {
    std::string_view protocol;
    std::string_view ways;
};

TEST(SectionsOfTheManual, TellTheWayTheLineAndThePeriodOfAProtocol) {
    for (const auto& [name, ways] : {
             Told{"sbus",
                  "Inputs and outputs, on a serial line, 100000 baud 8E2 unless `baud` says "
                  "otherwise. The `period` of an output is `\"14ms\"` by default, and at least "
                  "`\"7ms\"` without `force`."},
             Told{"crsf",
                  "Inputs and outputs, on a serial line, 420000 baud 8N1 unless `baud` says "
                  "otherwise. The `period` of an output is that of its messages, else `\"6667us\"` "
                  "by default, and at least `\"2ms\"` without `force`."},
             Told{"exbus",
                  "Inputs only, on a serial line, 125000 baud 8N1 unless `baud` says otherwise."},
             Told{"gamepad", "Inputs only, on an input device only."},
             Told{"joystick",
                  "Outputs only, on a virtual joystick only. The `period` of an output is "
                  "`\"8ms\"` by default, and at least `\"1ms\"` without `force`."},
             Told{"can",
                  "Inputs and outputs, on CAN. The `period` of an output is `\"10ms\"` by default, "
                  "and at least `\"2ms\"` without `force`."},
         }) {
        EXPECT_EQ(section(fmt::format("`{}`", name)).text,
                  fmt::format("{}. {}", find_protocol(name)->description, ways));
    }
}

TEST(SectionsOfTheManual, TellWhichOfTheKeysOfAProtocolAreForOutputs) {
    for (const Key& key : section("`joystick`").keys) {
        EXPECT_EQ(key.setting.scope, SettingScope::output) << key.name();
    }
    EXPECT_EQ(key_named(section("`sbus`").keys, "scale").setting.scope, SettingScope::both);
    EXPECT_EQ(key_named(section("`ibus`").keys, "slots").setting.scope, SettingScope::input);
    EXPECT_EQ(key_named(section("`ibus`").keys, "channels").setting.scope, SettingScope::output);
}

TEST(SectionsOfTheManual, HaveTheKeysInsideOfATreeBehindItsProtocol) {
    const auto all = manual_sections();
    const auto dbc = std::ranges::find(all, "`dbc`", &ManualSection::title);
    const ManualSection& signals = *(dbc + 1);
    EXPECT_EQ(signals.title, "A signal of `dbc`");
    EXPECT_EQ(signals.anchor, "dbc-signals");
    EXPECT_TRUE(signals.text.starts_with("A number is a channel; a table says more. Exactly one "));
    EXPECT_EQ(key_names(signals).front(), "channel");
    const ManualSection& battery =
        *(std::ranges::find(all, "`crsf-telemetry`", &ManualSection::title) + 1);
    EXPECT_EQ(battery.title, "`battery` of `crsf-telemetry`");
    EXPECT_EQ(battery.anchor, "crsf-telemetry-battery");
    EXPECT_EQ(
        battery.text,
        std::string(key_named(section("`crsf-telemetry`").keys, "battery").setting.help) + ".");
    EXPECT_EQ(key_names(battery), (Texts{"voltage", "current", "consumed", "remaining"}));
}

TEST(SectionsOfTheManual, HaveWholeSentences) {
    EXPECT_TRUE(section("The file").text.starts_with("\nA configuration is a [TOML]"));
    for (const ManualSection& one : manual_sections()) {
        EXPECT_TRUE(one.text.ends_with('.') || one.text.ends_with("```") ||
                    one.title == "`handover`")
            << one.title << one.text;
    }
}

}  // namespace
}  // namespace tribus::test::manual_sections_test
