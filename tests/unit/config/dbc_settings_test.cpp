#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/load.h"
#include "config/show/effective.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/config/examples.h"

/// The keys of protocol "dbc" as a user writes them, with the file that they name.
namespace tribus::test::dbc_settings_test {
namespace {

using Lines = std::vector<std::string>;
using std::chrono::milliseconds;

constexpr std::string_view kBus = R"(BO_ 304 Command: 8 A
 SG_ Speed : 16|8@1- (1,0) [-100|100] "%" B
 SG_ Good : 24|1@1+ (1,0) [0|1] "" B
BO_ 1797 Heartbeat: 1 A
 SG_ State : 0|8@1+ (1,0) [0|0] "" B
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 60000;
BA_ "GenMsgCycleTime" BO_ 304 50;
)";

constexpr std::string_view kStart = R"(
[pipeline]
main = { from = "receiver", to = "bus" }
[input.receiver]
protocol = "ibus"
device = "/dev/ttyA"
timeout = "2s"
[output.bus]
protocol = "dbc"
interface = "can0"
)";

class DbcSettings : public ::testing::Test {
  protected:
    DbcSettings() { folder_.write("bus.dbc", std::string(kBus)); }

    /// Loads a file whose line 11 is the first line of `end`.
    auto load(std::string_view end) const {
        return load_configuration(std::string(kStart) + std::string(end), folder_ / "t.toml");
    }
    /// Returns the mistakes as "line:column: text".
    template <class Loaded>
    static Lines told(const Loaded& configuration) {
        Lines lines;
        if (!configuration) {
            for (const Mistake& mistake : configuration.error()) {
                lines.push_back(format_mistake({"f", mistake.where, mistake.text}).substr(2));
            }
        }
        return lines;
    }
    Lines mistakes(std::string_view end) const { return told(load(end)); }
    /// Loads an input of the messages. Line 10 of the file is the first line of `end`.
    auto load_input(const std::string& end) const {
        return load_configuration(R"([pipeline]
main = { from = "bus", to = "servos" }
[output.servos]
protocol = "ibus"
device = "/dev/ttyA"
[input.bus]
protocol = "dbc"
interface = "can0"
dbc = "bus.dbc"
)" + end,
                                  folder_ / "t.toml");
    }
    Lines mistakes_of_input(const std::string& end) const { return told(load_input(end)); }
    static std::string with_cycle(std::string_view cycle) {
        return "signals.Command.Speed = 1\ncycles.Command = \"" + std::string(cycle) + "\"\n";
    }
    Configuration loaded(std::string_view end) const {
        auto configuration = load(end);
        if (!configuration) {
            ADD_FAILURE() << format_mistake(configuration.error().front());
            return {};
        }
        return *configuration;
    }

    TemporaryFolder folder_;
};

TEST_F(DbcSettings, TheFileIsSoughtInTheFolderOfTheConfiguration) {
    EXPECT_EQ(mistakes("dbc = \"bus.dbc\"\nsignals.Command.Speed = 1\n"), Lines{});
}

TEST_F(DbcSettings, TheFileAndTheSignalsAreRequired) {
    const Lines found = mistakes("");
    ASSERT_EQ(found.size(), 2U);
    EXPECT_NE(found[0].find("\"dbc\""), std::string::npos) << found[0];
    EXPECT_NE(found[1].find("\"signals\""), std::string::npos) << found[1];
}

TEST_F(DbcSettings, AMissingFileIsToldWhereItIsNamed) {
    EXPECT_EQ(mistakes("dbc = \"buss.dbc\"\nsignals.Command.Speed = 1\n"),
              Lines{"11:7: \"dbc\" is \"buss.dbc\": No such file or directory; allowed: the path "
                    "of a text file, relative to the folder of this file"});
}

TEST_F(DbcSettings, AMistakeInTheFileIsToldWithItsLineThere) {
    folder_.write("bad.dbc", "BO_ 1 M: 8 A\n SG_ S : 60|8@1+ (1,0) [0|0] \"\" B\n");
    const Lines found = mistakes("dbc = \"bad.dbc\"\nsignals.M.S = 1\n");
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0],
              "12:15: signal \"S\" cannot be used because of a mistake in line 2, column 6 of the "
              "DBC file: signal S needs 9 bytes, but message M has 8");
    folder_.write("cut.dbc", "BO_ 1 M: 8 A\nCM_ \"");
    EXPECT_EQ(mistakes("dbc = \"cut.dbc\"\nsignals.M.S = 1\n"),
              Lines{"11:7: cut.dbc:2:5: text without its closing quote"});
}

TEST_F(DbcSettings, UnknownNamesAreToldWhereTheyStandWithThoseThatExist) {
    EXPECT_EQ(mistakes("dbc = \"bus.dbc\"\n"
                       "[output.bus.signals.Command]\n"
                       "Speed = 1\n"
                       "Sped = 2\n"
                       "[output.bus.signals.Comand]\n"
                       "Speed = 3\n"),
              (Lines{"14:8: message \"Command\" has no signal \"Sped\"; allowed: \"Speed\", "
                     "\"Good\"",
                     "15:1: the DBC file has no message \"Comand\"; allowed: \"Command\", "
                     "\"Heartbeat\""}));
}

TEST_F(DbcSettings, AKeyWithALineBreakIsToldOnOneLine) {
    EXPECT_EQ(mistakes("dbc = \"bus.dbc\"\n"
                       "[output.bus.signals.Command]\n"
                       "\"Sp\\need\" = 1\n"
                       "Speed = { channel = 1, \"neg\\native\" = 2 }\n"
                       "[output.bus.signals.\"Com\\nmand\"]\n"
                       "Speed = 3\n"),
              (Lines{"13:13: message \"Command\" has no signal \"Sp\\u000aeed\"; allowed: "
                     "\"Speed\", \"Good\"",
                     "14:39: unknown key \"neg\\u000aative\"; allowed here: \"channel\", "
                     "\"value\", \"us\", \"not_available\", \"error\", \"optional\", \"negative\", "
                     "\"positive\", \"neutral\"",
                     "15:1: the DBC file has no message \"Com\\u000amand\"; allowed: "
                     "\"Command\", \"Heartbeat\""}));
}

TEST_F(DbcSettings, WrongTypesAreToldWhereTheyStand) {
    EXPECT_EQ(mistakes("dbc = \"bus.dbc\"\n"
                       "[output.bus.signals.Command]\n"
                       "Speed = { channel = 1, value = \"all\" }\n"
                       "Good = true\n"
                       "[output.bus.cycles]\n"
                       "Command = 20\n"),
              (Lines{"13:32: \"value\" has a wrong value; allowed: two different numbers, such "
                     "as [-100, 100]",
                     "14:8: this gives the signal no role; allowed: a channel number, or "
                     "one of { channel = 1 }, { flag = \"failsafe\" }, { fixed = 0 }, "
                     "{ counter = true }, { checksum = \"xor\" }, { from = \"battery.voltage\" }",
                     "16:11: a cycle time is a duration, text with a unit; allowed: \"1ms\" to "
                     "\"60s\""}));
}

TEST_F(DbcSettings, SignalsAreATable) {
    EXPECT_EQ(mistakes("dbc = \"bus.dbc\"\nsignals = 1\n"),
              Lines{"12:11: \"signals\" is 1; allowed: a table"});
}

TEST_F(DbcSettings, AnInputTakesEachChannelFromOneSignal) {
    EXPECT_EQ(mistakes_of_input("[input.bus.signals.Command]\nSpeed = 1\nGood = 1\n"),
              Lines{"12:8: channel 1 already comes from \"Command.Speed\"; allowed: one signal for "
                    "each channel"});
}

TEST_F(DbcSettings, AnInputWaitsLongerThanForOneCycleOfItsMessages) {
    const std::string_view signals = "signals.Command.Speed = 1\n";
    EXPECT_EQ(mistakes_of_input("timeout = \"51ms\"\n" + std::string(signals)), Lines{});
    EXPECT_EQ(mistakes_of_input("timeout = \"50ms\"\n" + std::string(signals)),
              Lines{"10:11: the timeout of input \"bus\" is \"50ms\", but its messages come every "
                    "\"50ms\": each pause between two would count as a loss; allowed: a longer "
                    "timeout; recommended: three times as long"});
}

TEST_F(DbcSettings, AnInputWaitsForThreeCyclesByDefaultButNotLessThanOthers) {
    const auto timeout = [&](std::string_view cycle) {
        const auto configuration = load_input(with_cycle(cycle));
        EXPECT_TRUE(configuration);
        return configuration ? configuration->inputs.at(0).supervision.timeout : Duration{};
    };
    EXPECT_EQ(timeout("10ms"), milliseconds(100));
    EXPECT_EQ(timeout("40ms"), milliseconds(120));
    EXPECT_EQ(timeout("1s"), milliseconds(3000));
    EXPECT_EQ(timeout("5s"), milliseconds(10'000)) << "the most that the key allows";
    EXPECT_EQ(
        mistakes_of_input(with_cycle("10s")),
        Lines{"6:8: the timeout of input \"bus\" is \"10s\" by default, but its messages come "
              "every \"10s\": each pause between two would count as a loss; allowed: a longer "
              "timeout; recommended: three times as long"});
}

TEST_F(DbcSettings, AnInputKnowsWhichChannelsAreOptional) {
    const auto configuration = load_input(
        "signals.Command.Speed = { channel = 1, optional = true }\n"
        "signals.Heartbeat.State = { channel = 2, value = [0, 100], us = [1000, 2000] }\n");
    ASSERT_TRUE(configuration) << format_mistake(configuration.error().front());
    EXPECT_EQ(configuration->inputs.at(0).supervision.optional_channels, 1U);
}

TEST_F(DbcSettings, ThePeriodIsTheCycleOfTheFileUnlessTheUserSaysOtherwise) {
    constexpr std::string_view kSignals = "dbc = \"bus.dbc\"\nsignals.Command.Speed = 1\n";
    EXPECT_EQ(loaded(kSignals).outputs.at(0).schedule.period, milliseconds(50));
    EXPECT_EQ(
        loaded(std::string(kSignals) + "cycles.Command = \"10ms\"\n").outputs.at(0).schedule.period,
        milliseconds(10));
    EXPECT_EQ(loaded(std::string(kSignals) + "period = \"30ms\"\n").outputs.at(0).schedule.period,
              milliseconds(30));
    EXPECT_EQ(
        loaded(std::string(kSignals) + "cycles.Command = \"5s\"\n").outputs.at(0).schedule.period,
        milliseconds(1000));
}

TEST_F(DbcSettings, WithoutAWordForFailsafeTheDefaultActionIsSilence) {
    EXPECT_EQ(loaded("dbc = \"bus.dbc\"\nsignals.Command.Speed = 1\n")
                  .pipelines.at(0)
                  .failsafe.at(0)
                  .action,
              FailsafeAction::silence);
    EXPECT_EQ(loaded("dbc = \"bus.dbc\"\nsignals.Command.Speed = 1\n"
                     "signals.Command.Good = { flag = \"good\" }\n")
                  .pipelines.at(0)
                  .failsafe.at(0)
                  .action,
              FailsafeAction::preset);
}

TEST_F(DbcSettings, TheEffectiveConfigurationMeansTheSame) {
    const Configuration first = loaded(
        "dbc = \"bus.dbc\"\n"
        "[output.bus.signals.Command]\n"
        "Speed = { channel = 3, value = [-1.5, 99], us = [2000, 1000], error = -128, optional = "
        "false }\n"
        "Good = { flag = \"good\" }\n"
        "[output.bus.signals.Heartbeat]\n"
        "State = { fixed = 5 }\n"
        "[output.bus.cycles]\n"
        "Heartbeat = \"1s\"\n");
    const std::string text = effective_toml(first);
    const auto second = load_configuration(text, folder_ / "t.toml");
    ASSERT_TRUE(second) << format_mistake(second.error().front()) << text;
    EXPECT_EQ(effective_toml(*second), text);
    const auto* before = first.outputs.at(0).settings.find_as<SettingTree>("signals");
    const auto* after = second->outputs.at(0).settings.find_as<SettingTree>("signals");
    ASSERT_NE(before, nullptr);
    ASSERT_NE(after, nullptr);
    EXPECT_EQ(*after, *before);
}

Configuration example(std::string_view name) {
    const auto configuration = load_configuration_file(config_folder() / "examples" / name);
    if (!configuration) {
        ADD_FAILURE() << format_mistake(configuration.error().front());
        return {};
    }
    return *configuration;
}

/// A missing value or message is failsafe without any flag.
TEST(DbcExamples, AnInputWithoutAFlagMayHaveTheDetectorsOfFlags) {
    const auto file = config_folder() / "examples" / "rc-box.toml";
    std::string text = content_of(file);
    text.insert(text.find("[input.box]\n") + 12, "failsafe_flag = true\n");
    const auto configuration = load_configuration(text, file.string());
    EXPECT_TRUE(configuration) << format_mistake(configuration.error().front());
}

TEST(DbcExamples, SayFailsafeWhereTheirFormatCan) {
    EXPECT_EQ(example("rc-box.toml").pipelines.at(0).failsafe.at(0).action,
              FailsafeAction::silence);
    EXPECT_EQ(example("rover-command.toml").pipelines.at(0).failsafe.at(0).action,
              FailsafeAction::silence);
    EXPECT_EQ(example("j1939-joystick.toml").pipelines.at(0).failsafe.at(0).action,
              FailsafeAction::preset);
    EXPECT_EQ(example("canopen-pdo.toml").pipelines.at(0).failsafe.at(0).action,
              FailsafeAction::preset);
}

struct Carried {
    std::string_view example;
    std::size_t channels = 0;
    double step = 0;  ///< the finest step of the format in microseconds
};

/// Goes through the encoder of the example's output and the decoder of its input.
class DbcExampleCarries : public ::testing::TestWithParam<Carried> {};

TEST_P(DbcExampleCarries, ItsChannelsInBothDirections) {
    const Configuration configuration = example(GetParam().example);
    ASSERT_EQ(configuration.inputs.at(1).protocol->name, "dbc");
    ASSERT_EQ(configuration.outputs.at(1).protocol->name, "dbc");
    const auto& output = configuration.outputs[1];
    const auto& input = configuration.inputs[1];
    FrameEncoder encoder(output.protocol->make_encoder(output.settings));
    const auto decoder = make_can_decoder(*input.protocol, input.settings);
    ChannelFrame sent;
    sent.frame_lost = sent.failsafe = false;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        const bool button = GetParam().channels == 8 && channel >= 4;
        sent.set(channel, button ? kSwitchOnPulse
                                 : Pulse::from_microseconds(1100 + 40 * static_cast<int>(channel)));
    }
    std::optional<ChannelFrame> received;
    for (int cycle = 0; cycle < 3; ++cycle) {
        const Instant now = Instant{} + std::chrono::seconds(1000) + milliseconds(20 * cycle);
        const auto frames = encoder.encode(sent, now).can_frames();
        for (const CanFrame& frame : frames) {
            const auto snapshot = decoder->next(frame, now);
            received = snapshot ? snapshot : received;
        }
    }
    ASSERT_TRUE(received);
    EXPECT_TRUE(received->good());
    std::size_t present = 0;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (received->has(channel)) {
            ++present;
            EXPECT_NEAR(received->channel(channel)->microseconds(),
                        sent.channel(channel)->microseconds(), GetParam().step / 2)
                << channel;
        }
    }
    EXPECT_EQ(present, GetParam().channels);
}

INSTANTIATE_TEST_SUITE_P(All, DbcExampleCarries,
                         ::testing::Values(Carried{"rc-box.toml", 16, 1},
                                           Carried{"j1939-joystick.toml", 8, 1},
                                           Carried{"canopen-pdo.toml", 8, 0.25},
                                           Carried{"rover-command.toml", 2, 5}));

}  // namespace
}  // namespace tribus::test::dbc_settings_test
