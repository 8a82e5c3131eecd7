#include "transports/codecs/dbc/map.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/dbc_maps.h"
#include "tests/unit/transports/codecs/dbc/map_bus.h"

namespace tribus::map_test {
namespace {

using namespace test;
using namespace map_bus;

TEST(DbcMap, WithoutValueTheRangeOfTheFileIsTheTravel) {
    const DbcMap map = map_of(R"({"Command": {"Speed": 3}})");
    EXPECT_EQ(only_channel(map).channel, 2U);
    EXPECT_EQ(only_channel(map).value, (std::array{-100.0, 100.0}));
    EXPECT_EQ(only_channel(map).microseconds, (std::array{1000.0, 2000.0}));
}

TEST(DbcMap, WithoutValueMicrosecondsArePulses) {
    const DbcMap map = map_of(R"({"Command": {"Pulse": 3}})");
    EXPECT_EQ(only_channel(map).value, only_channel(map).microseconds);
}

TEST(DbcMap, TheRangeOfAMagnitudeGoesBothWays) {
    const DbcMap map = map_of(R"({"Command": {"Magnitude": {"channel": 1, "negative": "Minus"}}})");
    EXPECT_EQ(only_channel(map).value, (std::array{-100.0, 100.0}));
}

TEST(DbcMap, CycleTimesComeFromTheFileOrTheUser) {
    const std::string_view both = R"({"Command": {"Speed": 1}, "Paged": {"First": 2}})";
    EXPECT_EQ(map_of(both).shortest_cycle(), milliseconds(20));
    EXPECT_EQ(map_of(both, SettingScope::output, R"({"Command": "1.5s"})").shortest_cycle(),
              milliseconds(50));
    EXPECT_EQ(map_of(R"({"Wide": {"Value": 1}})").shortest_cycle(), std::nullopt);
}

TEST(DbcMap, OnlyMessagesWithChannelsSetThePace) {
    EXPECT_EQ(
        map_of(R"({"Command": {"Mode": {"fixed": 1}}, "Paged": {"First": 2}})").shortest_cycle(),
        milliseconds(50));
}

TEST(DbcMap, SaysFailsafeByAFlagOrACodeInEachChannel) {
    EXPECT_FALSE(map_of(R"({"Command": {"Speed": 1}})").signals_failsafe());
    EXPECT_FALSE(
        map_of(R"({"Command": {"Speed": 1, "Minus": {"flag": "frame_lost"}}})").signals_failsafe());
    EXPECT_FALSE(
        map_of(R"({"Command": {"Speed": 1, "Pulse": {"flag": "cause"}}})").signals_failsafe());
    EXPECT_TRUE(
        map_of(R"({"Command": {"Speed": 1, "Minus": {"flag": "failsafe"}}})").signals_failsafe());
    EXPECT_TRUE(
        map_of(R"({"Command": {"Speed": 1, "Minus": {"flag": "good"}}})").signals_failsafe());
    EXPECT_TRUE(
        map_of(R"({"Command": {"Speed": {"channel": 1, "error": -128}}})").signals_failsafe());
    EXPECT_FALSE(map_of(R"({"Command": {"Speed": {"channel": 1, "error": -128}, "Pulse": 2}})")
                     .signals_failsafe());
}

TEST(DbcMap, AnOutputMaySendAChannelTwice) {
    EXPECT_EQ(mistakes(R"({"Command": {"Speed": 1, "Pulse": 1}})"), Lines{});
}

TEST(DbcMap, ReportsAMistakeOfTheFileWithItsPlace) {
    const Lines found = mistakes_of_signals("BO_ 1 M: 8 A\n SG_ S : 60|8@1+ (1,0) [0|0] \"\" B",
                                            R"({"M": {"S": 1}})", SettingScope::input);
    EXPECT_EQ(found,
              Lines{"signals.M.S: signal \"S\" cannot be used because of a mistake in line 2, "
                    "column 6 of the DBC file: signal S needs 9 bytes, but message M has 8"});
    EXPECT_EQ(mistakes_of_signals("BO_ 1 M: 8 A\nCM_ \"", R"({"M": {"S": 1}})").at(0),
              "dbc: bus.dbc:2:5: text without its closing quote");
}

TEST(DbcMap, TellsAllMistakesAtOnce) {
    EXPECT_EQ(mistakes(R"({"Command": {"Sped": 1, "Speed": 19}, "Comand": {"Speed": 1}})").size(),
              3U);
}

TEST(DbcMap, AMistakeInAMessageMakesNoneInItsCycle) {
    EXPECT_EQ(mistakes(R"({"Command": {"Sped": 1}})", SettingScope::input, R"({"Command": "10ms"})")
                  .size(),
              1U);
}

// The text after the place that several mistakes share.
const std::string kNoChannel =
    ": no signal carries a channel; allowed: at least one, such as SIGNAL = 1 below the name of "
    "its message, or SIGNAL = { from = \"battery.voltage\" }";
const std::string kOverlap =
    ": its bits overlap those of another signal in the same frame; allowed: signals that "
    "do not overlap";
const std::string kNoCycle =
    ": a cycle time is a duration, text with a unit; allowed: \"1ms\" to \"60s\"";
const std::string kCannotCount =
    ": this signal cannot be a counter; allowed: an unsigned signal of up to 32 bits that every "
    "frame of the message has";
const std::string kNoWholeByte =
    ": this signal cannot hold that checksum; allowed: one whole byte that every frame of the "
    "message has";

struct Wrong {
    std::string_view signals;
    std::string expected;
    SettingScope scope = SettingScope::output;
    std::string_view cycles = {};
};

class WrongDbcMap : public testing::TestWithParam<Wrong> {};

TEST_P(WrongDbcMap, IsToldWithItsPlaceAndWhatIsAllowed) {
    const Wrong& wrong = GetParam();
    EXPECT_EQ(mistakes(wrong.signals, wrong.scope, wrong.cycles), Lines{wrong.expected});
}

INSTANTIATE_TEST_SUITE_P(
    Names, WrongDbcMap,
    testing::Values(
        Wrong{R"({"Comand": {"Speed": 1}})",
              "signals.Comand: the DBC file has no message \"Comand\"; allowed: \"Command\", "
              "\"Paged\", \"Wide\", \"Joystick\", \"OneJoystick\", \"Long\""},
        Wrong{R"({"Wide": {"Speed": 1}})",
              "signals.Wide.Speed: message \"Wide\" has no signal \"Speed\"; allowed: \"Intel16\", "
              "\"Motorola16\", \"Byte0\", \"Value\", \"Float\""},
        Wrong{R"({"Command": 1})",
              "signals.Command: a message has signals; allowed: MESSAGE.SIGNAL = 1"},
        Wrong{R"({"Command": {"Speed": 1}, "Wide": {}})",
              "signals.Wide: no signal of the message has a role; allowed: at least one, such as "
              "SIGNAL = 1 or SIGNAL = { fixed = 5 }"},
        Wrong{"{}", "signals" + kNoChannel},
        Wrong{R"({"Command": {"Mode": {"fixed": 1}}})",
              "signals: no signal carries a channel; allowed: at least one, such as SIGNAL = 1 "
              "below the name of its message",
              SettingScope::input},
        Wrong{R"({"Long": {"L": 1}})",
              "signals.Long: the message is longer than a frame; allowed: messages of one frame"},
        Wrong{R"({"Joystick": {"X": 1}})",
              "signals.Joystick: the id of the message has the source address 0xFE, from which no "
              "node may send; add own_address = 0 to 253, the address of this node, to the output"},
        Wrong{R"({"Joystick": {"X": 1}, "OneJoystick": {"X1": 2}})",
              "signals.OneJoystick: a frame of this message may also be one of \"Joystick\", as "
              "their ids differ in the priority only, or one of them comes from any source (0xFE); "
              "allowed: only one of the two",
              SettingScope::input},
        Wrong{R"({"Command": {"Speed": 1, "Pulse": 1}})",
              "signals.Command.Pulse: channel 1 already comes from \"Command.Speed\"; allowed: one "
              "signal for each channel",
              SettingScope::input},
        Wrong{R"({"Command": {"Pulse": 1, "Short": {"fixed": 0}}})",
              "signals.Command.Short" + kOverlap},
        Wrong{R"({"Paged": {"First": 1, "Page": {"fixed": 1}}})",
              "signals.Paged.Page: \"Page\" is fixed to the page 1, but \"First\" is on another "
              "one; allowed: the signals of one page, or leave \"Page\" out: then each page is "
              "sent in turn"},
        Wrong{R"({"Paged": {"First": 1, "Second": 2, "Page": {"fixed": 1}}})",
              "signals.Paged.Page: \"Page\" is fixed to the page 1, but \"First\" is on another "
              "one; allowed: the signals of one page, or leave \"Page\" out: then each page is "
              "read",
              SettingScope::input},
        Wrong{R"({"Command": {"Magnitude": {"channel": 1, "negative": "Minus"},
                              "Minus": {"fixed": 0}}})",
              "signals.Command.Minus" + kOverlap},
        Wrong{R"({"Command": {"Speed": 1}})",
              "cycles.Wide: no signal of message \"Wide\" is mapped; allowed: \"Command\"",
              SettingScope::output, R"({"Wide": "1s"})"},
        Wrong{R"({"Command": {"Speed": 1}})", "cycles.Command" + kNoCycle, SettingScope::output,
              R"({"Command": 20})"},
        Wrong{R"({"Command": {"Speed": 1}})", "cycles.Command" + kNoCycle, SettingScope::output,
              R"({"Command": "61s"})"}));

INSTANTIATE_TEST_SUITE_P(
    Values, WrongDbcMap,
    testing::Values(
        Wrong{R"({"Command": {"Plain": 1}})",
              "signals.Command.Plain: the file gives no range of \"Plain\", so its values have no "
              "pulses; allowed: { channel = 1, value = [-100, 100], us = [1000, 2000] }"},
        Wrong{R"({"Command": {"Plain": {"channel": 1, "value": [-7, 7]}}})",
              "signals.Command.Plain.value: \"Plain\" cannot be -7; allowed: values that fit its 4 "
              "bits"},
        Wrong{R"({"Command": {"Speed": {"channel": 1, "value": [-100, 100.5]}}})",
              "signals.Command.Speed.value: \"Speed\" cannot be 100.5; the file allows -100 to "
              "100"},
        Wrong{R"({"Command": {"Short": 1}})",
              "signals.Command.Short.channel: \"Short\" cannot be 1000; allowed: values that fit "
              "its 8 bits"},
        Wrong{R"({"Command": {"Speed": {"channel": 1, "error": 128}}})",
              "signals.Command.Speed.error: 128 does not fit the 8 bits of \"Speed\"; "
              "allowed: a raw value that does"},
        Wrong{R"({"Command": {"Speed": 1, "Plain": {"fixed": 16}}})",
              "signals.Command.Plain.fixed: \"Plain\" cannot be 16; the nearest possible value is "
              "15"},
        Wrong{R"({"Command": {"Speed": 1, "Plain": {"fixed": 1.5}}})",
              "signals.Command.Plain.fixed: \"Plain\" cannot be 1.5; the nearest possible value is "
              "2"},
        Wrong{R"({"Command": {"Magnitude": {"channel": 1, "negative": "Sign"}}})",
              "signals.Command.Magnitude.negative: message \"Command\" has no signal \"Sign\"; "
              "allowed: \"Mode\", \"Speed\", \"Pulse\", \"Short\", \"Plain\", \"Magnitude\", "
              "\"Minus\", \"Count\", \"Check\""},
        Wrong{R"({"Command": {"Magnitude": {"channel": 1, "negative": "Count"}}})",
              "signals.Command.Magnitude.negative: \"Count\" cannot give the direction of "
              "\"Magnitude\"; allowed: another signal of 1 or 2 bits in the same frames"},
        Wrong{R"({"Paged": {"First": {"channel": 1, "negative": "SecondSign"}}})",
              "signals.Paged.First.negative: \"SecondSign\" cannot give the direction of "
              "\"First\"; allowed: another signal of 1 or 2 bits in the same frames"}));

INSTANTIATE_TEST_SUITE_P(
    Protection, WrongDbcMap,
    testing::Values(
        Wrong{R"({"Command": {"Pulse": 1, "Speed": {"counter": true}}})",
              "signals.Command.Speed" + kCannotCount},
        Wrong{R"({"Paged": {"First": 1, "Second": {"counter": true}}})",
              "signals.Paged.Second" + kCannotCount},
        Wrong{R"({"Wide": {"Value": 1, "Float": {"counter": true}}})",
              "signals.Wide.Float" + kCannotCount},
        Wrong{R"({"Command": {"Speed": 1, "Minus": {"flag": "cause"}}})",
              "signals.Command.Minus.flag: \"Minus\" is too narrow for a cause; allowed: 3 bits or "
              "more"},
        Wrong{R"({"Command": {"Speed": 1, "Count": {"counter": true, "most": 64}}})",
              "signals.Command.Count.most: \"Count\" cannot count that far; allowed: 1 to 63"},
        Wrong{
            R"({"Command": {"Speed": 1, "Count": {"counter": true}, "Plain": {"counter": true}}})",
            "signals.Command.Plain: the message already has a counter; allowed: one"},
        Wrong{R"({"Command": {"Speed": 1, "Check": {"checksum": "xor"},
                              "Mode": {"checksum": "sum"}}})",
              "signals.Command.Mode: the message already has a checksum; allowed: one"},
        Wrong{R"({"Command": {"Speed": 1, "Count": {"checksum": "sum"}}})",
              "signals.Command.Count" + kNoWholeByte},
        Wrong{R"({"Paged": {"First": 1, "SecondCheck": {"checksum": "sum"}}})",
              "signals.Paged.SecondCheck" + kNoWholeByte},
        Wrong{R"({"Command": {"Speed": 1, "Check": {"checksum": "p01", "data_id": 1}}})",
              "signals.Command.Check: this signal cannot hold that checksum; allowed: byte 0 "
              "(0|8@1+), "
              "and data after it"},
        Wrong{R"({"Wide": {"Value": 1, "Motorola16": {"checksum": "p05", "data_id": 1}}})",
              "signals.Wide.Motorola16: this signal cannot hold that checksum; allowed: bytes 0 "
              "and 1, "
              "low byte first (0|16@1+), and data after them"},
        Wrong{R"({"Wide": {"Value": 1, "Byte0": {"checksum": "p01"}}})",
              "signals.Wide.Byte0: the profile needs the data id of the message; allowed: "
              "data_id = 0 to 65535, or the attribute RcE2eDataId in the DBC file"}));

TEST(DbcMap, AnOutputSendsAtMost16Frames) {
    std::string dbc;
    std::string signals = "{";
    for (int i = 1; i <= 17; ++i) {
        const std::string number = std::to_string(i);
        dbc += "BO_ " + number + " M" + number + ": 1 A\n SG_ S" + number +
               " : 0|8@1+ (1,0) [0|9] \"\" B\n";
        signals += (i == 1 ? "" : ", ") + ("\"M" + number + "\": {\"S" + number + "\": 1}");
    }
    EXPECT_EQ(mistakes_of_signals(dbc, signals + "}"),
              Lines{"signals: they need 17 frames; allowed: at most 16"});
}

TEST(DbcMap, SaysThatAFileHasNoMessageAtAll) {
    EXPECT_EQ(mistakes_of_signals("VERSION \"\"\n", R"({"M": {"S": 1}})"),
              Lines{"signals.M: the DBC file has no message \"M\"; it has no messages: no line "
                    "begins with BO_"});
}

TEST(DbcMap, TellsWhichOfItsMessagesCannotSayFailsafe) {
    const DbcMap map =
        map_of(R"({"Command": {"Speed": 1, "Minus": {"flag": "failsafe"}}, "Wide": {"Value": 2}})");
    EXPECT_TRUE(map.signals_failsafe());
    EXPECT_TRUE(map.message_signals_failsafe(0));
    EXPECT_FALSE(map.message_signals_failsafe(1));
}

}  // namespace
}  // namespace tribus::map_test
