#include "config/check/warnings.h"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"
#include "tests/unit/config/main_job.h"

/// Configurations that look right and are not: accepted, with a warning and its line.
namespace tribus::test::warnings_test {
namespace {

using Lines = std::vector<std::string>;

Lines warnings_in(std::string_view text) {
    Lines lines;
    for (const Mistake& warning : warnings_about(loaded(text))) {
        lines.push_back(format_mistake(warning));
    }
    return lines;
}

class Doubtful : public ::testing::TestWithParam<Spoilt> {};

TEST_P(Doubtful, IsAcceptedWithAWarning) {
    const Spoilt& spoilt = GetParam();
    EXPECT_EQ(warnings_in(main_job_with(spoilt.line, spoilt.replacement)),
              Lines{std::string(spoilt.expected)});
}

std::string name_of(const ::testing::TestParamInfo<Spoilt>& doubtful) {
    return std::string(doubtful.param.name);
}

constexpr Spoilt kRules[]{
    {"loss_at_every_position", 3,
     "device = \"/dev/ttyA\"\nfailsafe_when = [{ channel = 3, between = [900, 2100] }]",
     "t.toml:4:18: this rule of \"failsafe_when\": every position of a stick from 1000 to 2000 us "
     "means a loss, so the link would never count; give a narrower range"},
    {"loss_above_less_than_any_stick", 3,
     "device = \"/dev/ttyA\"\nfailsafe_when = [{ channel = 3, above = 950 }]",
     "t.toml:4:18: this rule of \"failsafe_when\": every position of a stick from 1000 to 2000 us "
     "means a loss, so the link would never count; give a narrower range"},
    {"loss_by_a_channel_that_the_protocol_lacks", 2,
     "protocol = \"crsf\"\nfailsafe_when = [{ channel = 17, below = 950 }]",
     "t.toml:3:18: this rule of \"failsafe_when\": the input has no channel 17, so the rule never "
     "says anything; give a channel that it has"},
    {"release_below_the_least_value", 10,
     "[pipeline.main.failsafe]\nrelease_when = { channel = 3, below = 900 }",
     "t.toml:11:16: \"release_when\": the channel gets no such value, since it goes from 988 to "
     "2012 us with the usual travel of a stick, so control would never be given"},
    {"release_below_the_least_value_of_the_map", 10,
     "[pipeline.main.channels]\n3 = { from = 3, min = 1100 }\n"
     "[pipeline.main.failsafe]\naction = \"silence\"\n"
     "release_when = { channel = 3, below = 1050 }",
     "t.toml:14:16: \"release_when\": the channel gets no such value, since it goes from 1100 to "
     "2012 us with the usual travel of a stick, so control would never be given"},
    {"release_at_every_position", 10,
     "[pipeline.main.failsafe]\nrelease_when = { channel = 3, between = [900, 2100] }",
     "t.toml:11:16: \"release_when\": every value that the channel can have releases control, so "
     "it holds nothing back; leave it out, or give a narrower range"},
    {"switch_that_is_always_on", 10, "[pipeline.main.channels]\n5 = { from = 5, above = 950 }",
     "t.toml:11:5: this switch: every position of a stick from 1000 to 2000 us switches it on, so "
     "it would always be on; give a narrower range"},
    {"switch_that_is_never_on", 10, "[pipeline.main.channels]\n5 = { from = 5, above = 2100 }",
     "t.toml:11:5: this switch: the channel gets no such value, since it goes from 988 to 2012 "
     "us with the usual travel of a stick, so it would never be on"},
};
INSTANTIATE_TEST_SUITE_P(Rules, Doubtful, ::testing::ValuesIn(kRules), name_of);

constexpr Spoilt kValues[]{
    {"preset_below_min", 10,
     "[pipeline.main.channels]\n3 = { from = 3, min = 1100, max = 1900 }\n"
     "[pipeline.main.failsafe]\npreset = { 3 = 988, other = 1500 }",
     "t.toml:13:16: the preset of channel 3 is 988 us, outside of its \"min\" and \"max\" (1100 to "
     "1900): presets are sent as they are; give a preset within them, or other limits"},
    {"default_preset_below_min", 10, "[pipeline.main.channels]\n3 = { from = 3, min = 1100 }",
     "t.toml:11:5: the default preset of channel 3 is 988 us, outside of its \"min\" and \"max\" "
     "(1100 to no limit): presets are sent as they are; give a preset within them, or other "
     "limits"},
    {"slew_of_a_channel", 10, "[pipeline.main.channels]\n1 = { from = 1, slew = \"1us/s\" }",
     "t.toml:11:24: \"slew\" is \"1us/s\", so the way from 1000 to 2000 us takes 1000 seconds; "
     "usual are \"500us/s\" and more"},
    {"slew_into_presets", 10, "[pipeline.main.failsafe]\nslew = \"1us/s\"",
     "t.toml:11:8: \"slew\" is \"1us/s\", so the way from 1000 to 2000 us takes 1000 seconds; "
     "usual are \"500us/s\" and more"},
    {"frozen_shorter_than_the_timeout", 3, "device = \"/dev/ttyA\"\nfrozen = \"20ms\"",
     "t.toml:4:10: \"frozen\" is \"20ms\", shorter than the timeout, \"100ms\": a stick that lies "
     "still for a few frames would be a loss; usual are \"2s\" and more"},
    {"plausible_without_full_travel", 3, "device = \"/dev/ttyA\"\nplausible = [1400, 1600]",
     "t.toml:4:13: \"plausible\" is [1400, 1600]: a stick at full travel, 1000 or 2000 us, is "
     "outside, and its frames would not count; usual are [800, 2200]"},
};
INSTANTIATE_TEST_SUITE_P(Values, Doubtful, ::testing::ValuesIn(kValues), name_of);

constexpr Spoilt kPlaces[]{
    {"device_without_a_leading_slash", 3, "device = \"ttyA\"",
     "t.toml:3:10: \"device\" is \"ttyA\", which counts from the folder in which the program is "
     "started; write the whole path, such as \"/dev/ttyA\""},
    {"device_that_lacks_only_the_slash", 3, "device = \"dev/ttyA\"",
     "t.toml:3:10: \"device\" is \"dev/ttyA\", which counts from the folder in which the program "
     "is started; write the whole path, such as \"/dev/ttyA\""},
    {"one_port_by_two_paths", 6, "device = \"/dev/./ttyA\"",
     "t.toml:6:10: device \"/dev/./ttyA\" is the port that [input.receiver] in line 3 names "
     "\"/dev/ttyA\", and only one of the two can open it; give both the same name"},
};
INSTANTIATE_TEST_SUITE_P(Places, Doubtful, ::testing::ValuesIn(kPlaces), name_of);

TEST(Warnings, AreAboutTheChannelsThatTheSettingsLeaveOut) {
    const std::string rule = "failsafe_when = [{ channel = 15, below = 950 }]";
    EXPECT_EQ(warnings_in(main_job_with(3, "device = \"/dev/ttyA\"\nslots = \"plain\"\n" + rule)),
              Lines{"t.toml:5:18: this rule of \"failsafe_when\": the input has no channel 15, so "
                    "the rule never says anything; give a channel that it has"});
    EXPECT_EQ(warnings_in(main_job_with(3, "device = \"/dev/ttyA\"\n" + rule)), Lines{});
}

TEST(Warnings, AreNoneOfAnUsualConfiguration) {
    EXPECT_EQ(warnings_in(main_job_with(
                  10,
                  "[pipeline.main.channels]\n3 = { from = 3, min = 900, slew = \"500us/s\" }\n"
                  "5 = { from = 5, above = 1700 }\n"
                  "[pipeline.main.failsafe]\npreset = { 3 = 988, other = 1500 }\n"
                  "release_when = { channel = 3, below = 1050 }\nslew = \"1000us/s\"")),
              Lines{});
    EXPECT_EQ(warnings_in(main_job_with(
                  3,
                  "device = \"/dev/ttyA\"\nfrozen = \"2s\"\nplausible = [850, 2150]\n"
                  "failsafe_when = [{ channel = 3, below = 950 }, { channel = 3, between = [985, "
                  "995] }]")),
              Lines{});
}

TEST(Warnings, AreAboutAnInputDeviceWithoutALeadingSlash) {
    const Lines lines = warnings_in(
        "[input.pad]\nprotocol = \"gamepad\"\ndevice = \"dev/input/event3\"\n"
        "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
        "[pipeline.main]\nfrom = \"pad\"\nto = \"servos\"\n");
    ASSERT_EQ(lines.size(), 1U);
    EXPECT_NE(lines[0].find("such as \"/dev/input/event3\""), std::string::npos) << lines[0];
}

/// SBUS sends the lower end of a stick as 987.5 us, the upper one as 2011.5 us.
TEST(Warnings, AreNoneOfARuleAtTheEndOfAStick) {
    EXPECT_EQ(warnings_in(main_job_with(10,
                                        "[pipeline.main.failsafe]\nrelease_when = { channel = 3, "
                                        "below = 988 }")),
              Lines{});
}

TEST(Warnings, SayHowManyMoreThereAre) {
    std::string text;
    for (int output = 0; output < 7; ++output) {
        const std::string n = std::to_string(output);
        text += "[input.i" + n + "]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyI" + n +
                "\"\n[output.o" + n + "]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyO" + n +
                "\"\n[pipeline.p" + n + "]\nfrom = \"i" + n + "\"\nto = \"o" + n +
                "\"\n[pipeline.p" + n + ".channels]\n";
        for (int channel = 1; channel <= 14; ++channel) {
            const std::string c = std::to_string(channel);
            text += c + " = { from = " + c + ", min = 900, max = 2100, slew = \"1us/s\" }\n";
        }
    }
    Lines lines = warnings_in(text +
                              "[pipeline.p0.failsafe]\nslew = \"1us/s\"\n"
                              "[pipeline.p1.failsafe]\nslew = \"1us/s\"\n"
                              "[pipeline.p2.failsafe]\nslew = \"1us/s\"\n");
    ASSERT_EQ(lines.size(), 101U);
    EXPECT_EQ(lines.back(), "t.toml: and 1 more");
}

std::string udp_both_ways(std::string_view heard, std::string_view sent) {
    return "[input.u]\nprotocol = \"sbus\"\naddress = \"" + std::string(heard) +
           "\"\npublic = true\n[output.u]\nprotocol = \"sbus\"\naddress = \"" + std::string(sent) +
           "\"\npublic = true\n[pipeline.main]\nfrom = \"u\"\nto = \"u\"\n";
}

TEST(Warnings, AreAboutAUdpOutputThatItsOwnInputHears) {
    for (const auto& [heard, sent] :
         {std::pair("0.0.0.0:5501", "127.0.0.1:5501"), std::pair("127.0.0.1:5501", "0.0.0.0:5501"),
          std::pair("[::]:5501", "[::1]:5501")}) {
        EXPECT_EQ(warnings_in(udp_both_ways(heard, sent)),
                  Lines{"t.toml:3:11: [input.u] hears at \"" + std::string(heard) +
                        "\" what [output.u] in line 7 sends to \"" + sent +
                        "\", so this program would follow itself; give them different ports"});
    }
    EXPECT_EQ(warnings_in(udp_both_ways("0.0.0.0:5501", "127.0.0.1:5502")), Lines{});
    EXPECT_EQ(warnings_in(udp_both_ways("0.0.0.0:5501", "192.168.1.7:5501")), Lines{});
    EXPECT_EQ(warnings_in(udp_both_ways("[::]:5501", "127.0.0.1:5501")), Lines{})
        << "an input hears one version (docs/protocols/network.md)";
}

/// A folder with a DBC file.
class DbcWarnings : public ::testing::Test {
  protected:
    DbcWarnings() {
        folder_.write("bus.dbc",
                      "BO_ 256 M: 8 A\n"
                      " SG_ X : 0|16@1+ (1,0) [800|2200] \"us\" B\n"
                      " SG_ Lost : 16|1@1+ (1,0) [0|1] \"\" B\n"
                      "BO_ 257 N: 8 A\n"
                      " SG_ Y : 0|16@1+ (1,0) [800|2200] \"us\" B\n"
                      "BO_ 258 Bad: 9 A\n");
    }

    Lines warnings(std::string_view text) const {
        Lines lines;
        const auto configuration = load_configuration(text, folder_ / "t.toml");
        if (!configuration) {
            ADD_FAILURE() << format_mistake(configuration.error().front());
            return lines;
        }
        for (const Mistake& warning : warnings_about(*configuration)) {
            std::string line = format_mistake(warning);
            for (std::size_t at = line.find(folder_ / ""); at != std::string::npos;
                 at = line.find(folder_ / "")) {
                line.erase(at, (folder_ / "").size());
            }
            lines.push_back(std::move(line));
        }
        return lines;
    }

    TemporaryFolder folder_;
};

const std::string kBadFile =
    "bus.dbc:6:14: message Bad has 9 bytes; a CAN frame has 0 to 8, with FD also 12, 16, 20, 24, "
    "32, 48 or 64";

TEST_F(DbcWarnings, NameTheMessageThatCannotSayFailsafeAndBrokenOnes) {
    EXPECT_EQ(warnings("[input.rx]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n"
                       "[output.bus]\nprotocol = \"dbc\"\ninterface = \"can0\"\ndbc = \"bus.dbc\"\n"
                       "signals.M = { X = 1, Lost = { flag = \"failsafe\" } }\n"
                       "signals.N = { Y = 2 }\n"
                       "[pipeline.main]\nfrom = \"rx\"\nto = \"bus\"\n"),
              (Lines{"t.toml:7:7: " + kBadFile,
                     "t.toml:9:13: its frames cannot say failsafe, although other messages of this "
                     "output can: their receiver sees held values and presets unmarked; add a "
                     "signal with { flag = \"failsafe\" } or { flag = \"good\" }, or \"error\" or "
                     "\"not_available\" to each of its channels"}));
}

TEST_F(DbcWarnings, AreAboutRulesOfChannelsThatNoSignalCarries) {
    EXPECT_EQ(warnings("[input.bus]\nprotocol = \"dbc\"\ninterface = \"can0\"\ndbc = \"bus.dbc\"\n"
                       "signals.M = { X = 1 }\n"
                       "failsafe_when = [{ channel = 2, below = 900 }]\n"
                       "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n"
                       "[pipeline.main]\nfrom = \"bus\"\nto = \"servos\"\n"),
              (Lines{"t.toml:4:7: " + kBadFile,
                     "t.toml:6:18: this rule of \"failsafe_when\": the input has no channel 2, so "
                     "the rule never says anything; give a channel that it has"}));
}

TEST_F(DbcWarnings, AreAboutValuesThatAnOwnOutputSends) {
    EXPECT_EQ(warnings("[input.rx]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n"
                       "[output.bus]\nprotocol = \"dbc\"\ninterface = \"can0\"\ndbc = \"bus.dbc\"\n"
                       "signals.M = { X = 1 }\n"
                       "[values.own]\ninterface = \"can0\"\ndbc = \"bus.dbc\"\nmessage = \"M\"\n"
                       "[pipeline.main]\nfrom = \"rx\"\nto = \"bus\"\n"),
              (Lines{"t.toml:7:7: " + kBadFile,
                     "t.toml:10:13: [values.own] reads on \"can0\" a message that [output.bus] in "
                     "line 6 sends, so its values come from this program itself; read a message "
                     "of another node",
                     "t.toml:11:7: " + kBadFile}));
}

}  // namespace
}  // namespace tribus::test::warnings_test
