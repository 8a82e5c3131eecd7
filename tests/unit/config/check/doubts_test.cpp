#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "config/check/warnings.h"
#include "tests/unit/config/main_job.h"

/// Where a value is just doubtful, and where just not.
namespace tribus::test::doubts_test {
namespace {

using Lines = std::vector<std::string>;

/// Returns the warnings without the name of the file.
Lines warnings_with(std::size_t line, std::string_view replacement) {
    Lines lines;
    for (const Mistake& warning : warnings_about(loaded(main_job_with(line, replacement)))) {
        lines.push_back(format_mistake(warning).substr(7));
    }
    return lines;
}

/// A map of channel 3 and the limit of a release by it. The release stands in line 13.
Lines release(std::string_view map, std::string_view limit) {
    return warnings_with(10, "[pipeline.main.channels]\n" + std::string(map) +
                                 "\n[pipeline.main.failsafe]\nrelease_when = { channel = 3, " +
                                 std::string(limit) + " }");
}

Lines never(std::string_view from_to) {
    return {"13:16: \"release_when\": the channel gets no such value, since it goes from " +
            std::string(from_to) + ", so control would never be given"};
}
constexpr std::string_view kNoMap = "4 = 4";

TEST(ReleaseAtTheEndOfAStick, IsDoubtfulBeyondWhatProtocolsRound) {
    EXPECT_EQ(release(kNoMap, "below = 988"), Lines{});
    EXPECT_EQ(release(kNoMap, "below = 987"),
              never("988 to 2012 us with the usual travel of a stick"));
    EXPECT_EQ(release(kNoMap, "above = 2012"), Lines{});
    EXPECT_EQ(release(kNoMap, "above = 2013"),
              never("988 to 2012 us with the usual travel of a stick"));
}

TEST(ReleaseByAFixedChannel, IsAlwaysOrNever) {
    EXPECT_EQ(release("3 = { fixed = 1500 }", "below = 1400"), never("1500 to 1500 us"));
    EXPECT_EQ(release("3 = { fixed = 1500 }", "above = 1400"),
              Lines{"13:16: \"release_when\": every value that the channel can have releases "
                    "control, so it holds nothing back; leave it out, or give a narrower range"});
}

TEST(ReleaseByASwitch, HasFullTravel) {
    EXPECT_EQ(release("3 = { from = 5, above = 1700 }", "below = 990"), never("1000 to 2000 us"));
    EXPECT_EQ(
        warnings_with(10,
                      "[pipeline.main.channels]\n3 = { line = \"bind\" }\n"
                      "[pipeline.main.failsafe]\nrelease_when = { channel = 3, below = 990 }\n"
                      "[gpio.bind]\nline = \"A\"\nrole = \"button\""),
        never("1000 to 2000 us"));
}

TEST(ReleaseByAMix, MayHaveAnyValue) {
    EXPECT_EQ(release("3 = { mix = { 1 = 1 } }", "below = 600"), Lines{});
    EXPECT_EQ(release("3 = { mix = { 1 = 1 }, max = 2000 }", "above = 2100"),
              never("0 to 2000 us"));
}

TEST(ReleaseByATrimmedChannel, CountsTheTrim) {
    EXPECT_EQ(release("3 = { from = 3, trim = 50 }", "below = 900"),
              never("988 to 2062 us with the usual travel of a stick"));
    EXPECT_EQ(release("3 = { from = 3, trim = -50 }", "above = 2100"),
              never("938 to 2012 us with the usual travel of a stick"));
}

TEST(RuleOfAllZero, IsNotDoubtful) {
    EXPECT_EQ(warnings_with(2, "protocol = \"sbus\"\nfailsafe_when = [{ all_zero = true }]"),
              Lines{});
}

TEST(RuleOfAChannelThatTheInputLacks, IsDoubtfulOnce) {
    EXPECT_EQ(
        warnings_with(2, "protocol = \"crsf\"\nfailsafe_when = [{ channel = 17, above = 950 }]"),
        Lines{"3:18: this rule of \"failsafe_when\": the input has no channel 17, so the rule "
              "never says anything; give a channel that it has"});
    EXPECT_EQ(
        warnings_with(2, "protocol = \"crsf\"\nfailsafe_when = [{ channel = 16, below = 950 }]"),
        Lines{});
}

TEST(LineOfASwitch, IsDoubtfulWhereItIsAlwaysOn) {
    EXPECT_EQ(warnings_with(10,
                            "[gpio.a]\nline = \"A\"\nrole = \"switch\"\noutput = \"servos\"\n"
                            "channel = 9\nabove = 950"),
              Lines{"14:11: [gpio.a]: every position of a stick from 1000 to 2000 us switches it "
                    "on, so it would always be on; give a narrower range"});
}

TEST(Slew, IsDoubtfulWhereFullTravelTakesMoreThanAMinute) {
    const auto with = [](std::string_view slew) {
        return warnings_with(10, "[pipeline.main.channels]\n1 = { from = 1, slew = \"" +
                                     std::string(slew) + "us/s\" }");
    };
    EXPECT_EQ(with("16.6"), Lines{});
    EXPECT_EQ(with("2"),
              Lines{"11:24: \"slew\" is \"2us/s\", so the way from 1000 to 2000 us takes 500 "
                    "seconds; usual are \"500us/s\" and more"});
}

TEST(Frozen, MayBeAsLongAsTheTimeout) {
    EXPECT_EQ(warnings_with(3, "device = \"/dev/ttyA\"\nfrozen = \"100ms\""), Lines{});
}

TEST(PlausibleRange, HoldsFullTravel) {
    const auto with = [](std::string_view range) {
        return warnings_with(3, "device = \"/dev/ttyA\"\nplausible = " + std::string(range)).size();
    };
    EXPECT_EQ(with("[1000, 2000]"), 0U);
    EXPECT_EQ(with("[1001, 2000]"), 1U);
    EXPECT_EQ(with("[1000, 1999]"), 1U);
}

/// The limits of channel 3 and its preset.
Lines preset(std::string_view limits, std::string_view preset) {
    return warnings_with(10, "[pipeline.main.channels]\n3 = { from = 3, " + std::string(limits) +
                                 " }\n[pipeline.main.failsafe]\npreset = " + std::string(preset));
}

TEST(Preset, MayBeALimitOfItsChannel) {
    EXPECT_EQ(preset("min = 1100, max = 1900", "{ 3 = 1100 }"), Lines{});
    EXPECT_EQ(preset("min = 1100, max = 1900", "{ 3 = 1900 }"), Lines{});
}

TEST(PresetForOtherChannels, IsDoubtfulWhereItStands) {
    EXPECT_EQ(preset("min = 1100", "{ 4 = 1500, other = 1000 }"),
              Lines{"13:30: the preset of channel 3 is 1000 us, outside of its \"min\" and \"max\" "
                    "(1100 to no limit): presets are sent as they are; give a preset within them, "
                    "or other limits"});
}

std::string outside(std::string_view place, std::string_view channel, std::string_view limits) {
    return std::string(place) + ": the default preset of channel " + std::string(channel) +
           " us, outside of its \"min\" and \"max\" (" + std::string(limits) +
           "): presets are sent as they are; give a preset within them, or other limits";
}

TEST(DefaultPresets, AreDoubtfulOnceForEachChannel) {
    EXPECT_EQ(warnings_with(9,
                            "to = [\"servos\", \"b\"]\n[pipeline.main.channels]\n"
                            "3 = { from = 3, min = 1100 }\n4 = { from = 4, max = 1400 }\n"
                            "[output.b]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyC\""),
              (Lines{outside("11:5", "3 is 988", "1100 to no limit"),
                     outside("12:5", "4 is 1500", "no limit to 1400")}));
}

TEST(Changeover, IsDoubtfulWhereItTakesMoreThanAMinute) {
    EXPECT_EQ(warnings_with(7,
                            "[input.b]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyC\"\n"
                            "[pipeline.second]\nfrom = [\"receiver\", \"b\"]\nto = \"c\"\n"
                            "changeover = \"1us/s\"\n"
                            "[output.c]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyD\"\n"
                            "[pipeline.main]"),
              Lines{"13:14: \"changeover\" is \"1us/s\", so the way from 1000 to 2000 us takes "
                    "1000 seconds; usual are \"500us/s\" and more"});
}

TEST(Remarks, StandAmongTheWarningsInTheOrderOfTheFile) {
    const Lines found = warnings_with(3,
                                      "device = \"/dev/ttyA\"\nfrozen = \"20ms\"\n"
                                      "map = { 3 = 16 }\nplausible = [1400, 1600]");
    ASSERT_EQ(found.size(), 3U);
    EXPECT_EQ(found[0].substr(0, 6), "4:10: ");
    EXPECT_EQ(found[1].substr(0, 6), "5:13: ");
    EXPECT_EQ(found[2].substr(0, 6), "6:13: ");
}

}  // namespace
}  // namespace tribus::test::doubts_test
