#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"
#include "tests/unit/config/main_job.h"
#include "transports/codecs/mavlink/mavlink.h"
#include "transports/registry/registry.h"

/// [input.NAME] and [output.NAME] of MAVLink as a user writes them.
namespace tribus::test::mavlink_protocol_test {
namespace {

using Lines = std::vector<std::string>;

Lines to_autopilot(const std::string& lines, const std::string& file = "t.toml") {
    return mistakes_in(
        "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n"
        "[output.drone]\nprotocol = \"mavlink\"\ndevice = \"/dev/ttyB\"\n" +
            lines + "[pipeline.main]\nfrom = \"receiver\"\nto = \"drone\"\n",
        file);
}

Lines from_autopilot(const std::string& lines, const std::string& file = "t.toml") {
    return mistakes_in("[input.drone]\nprotocol = \"mavlink\"\naddress = \"127.0.0.1:14550\"\n" +
                           lines +
                           "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n"
                           "[pipeline.main]\nfrom = \"drone\"\nto = \"servos\"\n",
                       file);
}

TEST(MavlinkProtocol, NeedsAPlaceOnly) {
    EXPECT_EQ(to_autopilot(""), Lines{});
    EXPECT_EQ(from_autopilot(""), Lines{});
}

TEST(MavlinkProtocol, TakesEveryMessageWithItsKeys) {
    EXPECT_EQ(to_autopilot("message = \"rc_channels_override\"\nversion = 1\nchannels = 8\n"
                           "on_loss = \"release\"\nsystem = 254\ncomponent = 68\ntarget = 2\n"),
              Lines{});
    EXPECT_EQ(to_autopilot("message = \"manual_control\"\nbuttons = 14\nthrottle = \"centred\"\n"),
              Lines{});
    EXPECT_EQ(from_autopilot("message = \"rc_channels\"\nsystem = 1\n"), Lines{});
    EXPECT_EQ(from_autopilot("message = \"manual_control\"\nbuttons = 3\ntarget = 7\n"), Lines{});
}

TEST(MavlinkProtocol, SaysWhatAMessageCannotDo) {
    EXPECT_EQ(to_autopilot("version = 1\n"),
              Lines{"t.toml:7:11: \"version\" is 1, which has no radio_rc_channels; allowed: 2, "
                    "or message = \"rc_channels_override\""});
    EXPECT_EQ(to_autopilot("message = \"rc_channels_override\"\nversion = 1\nchannels = 9\n"),
              Lines{"t.toml:9:12: \"channels\" is 9, and MAVLink 1 carries 8; allowed: 1 to 8, or "
                    "version = 2"});
    EXPECT_EQ(to_autopilot("on_loss = \"release\"\n"),
              Lines{"t.toml:7:11: \"on_loss\" is \"release\", and only rc_channels_override can "
                    "give channels back; allowed: \"silence\""});
    EXPECT_EQ(to_autopilot("message = \"manual_control\"\nchannels = 4\n"),
              Lines{"t.toml:8:12: \"channels\" has no effect with manual_control, which carries "
                    "channels 1 to 4 and \"buttons\"; leave it out"});
    EXPECT_EQ(from_autopilot("buttons = 4\n"),
              Lines{"t.toml:4:11: \"buttons\" has no effect without message = "
                    "\"manual_control\"; leave it out"});
    EXPECT_EQ(to_autopilot("throttle = \"centred\"\n"),
              Lines{"t.toml:7:12: \"throttle\" has no effect without message = "
                    "\"manual_control\"; leave it out"});
}

/// What `check` warns of in an output or input with manual_control.
Lines doubts(const std::string& throttle, SettingScope scope = SettingScope::output) {
    SettingValues settings;
    settings.set("message", std::string("manual_control"));
    if (!throttle.empty()) {
        settings.set("throttle", throttle);
    }
    Lines texts;
    for (const SettingMistake& doubt : kMavlinkProtocol.warnings(settings, scope)) {
        texts.push_back(doubt.text);
    }
    return texts;
}

TEST(MavlinkProtocol, AsksHowTheThrottleOfTheVehicleCounts) {
    EXPECT_EQ(doubts(""),
              Lines{"\"manual_control\" without \"throttle\": on a rover or boat with ArduPilot a "
                    "centred stick would be half throttle, and reverse could not be reached; add "
                    "throttle = \"centred\" for such a vehicle, throttle = \"zero based\" for all "
                    "others"});
    EXPECT_EQ(doubts("centred"), Lines{});
    EXPECT_EQ(doubts("zero based"), Lines{});
    EXPECT_EQ(doubts("", SettingScope::input), Lines{});
    EXPECT_EQ(kMavlinkProtocol.warnings({}, SettingScope::output).size(), 0U);
}

/// 988 us is standstill with a zero-based throttle, and full reverse with a centred one.
TEST(MavlinkProtocol, WantsAWrittenPresetOfACentredThrottle) {
    const auto with_presets = [&](const std::string& throttle, const std::string& preset) {
        return to_autopilot("message = \"manual_control\"\nthrottle = \"" + throttle +
                            "\"\n[pipeline.main.failsafe]\naction = \"preset\"\n" + preset);
    };
    const Lines refused = with_presets("centred", "");
    ASSERT_EQ(refused.size(), 1U);
    EXPECT_NE(refused[0].find("the preset of channel 3 is not written"), std::string::npos);
    EXPECT_NE(refused[0].find("such as preset = { 3 = 1500, other = 1500 }"), std::string::npos)
        << "the other axes keep their centre";
    EXPECT_EQ(with_presets("centred", "preset = { 3 = 1500 }\n"), Lines{});
    EXPECT_EQ(with_presets("zero based", ""), Lines{});
}

TEST(MavlinkProtocol, SendsNoRcChannelsWhichOnlyAutopilotsSend) {
    EXPECT_EQ(to_autopilot("message = \"rc_channels\"\n"),
              Lines{"t.toml:7:11: \"message\" is \"rc_channels\", which only autopilots send; "
                    "allowed: \"radio_rc_channels\", \"rc_channels_override\", "
                    "\"manual_control\""});
}

TEST(MavlinkProtocol, SignalsFailsafeByItsFlagOrByTheStateOfTheAutopilot) {
    EXPECT_TRUE(kMavlinkProtocol.signals_failsafe({}));
    for (const auto& [message, signals] :
         {std::pair("radio_rc_channels", true), std::pair("rc_channels", true),
          std::pair("rc_channels_override", false), std::pair("manual_control", false)}) {
        SettingValues settings;
        settings.set("message", std::string(message));
        EXPECT_EQ(kMavlinkProtocol.signals_failsafe(settings), signals) << message;
    }
}

/// A key file, and configurations beside it.
class MavlinkKeys : public ::testing::Test {
  protected:
    MavlinkKeys() {
        std::filesystem::permissions(folder_.write("drone.key", std::string(64, '7')),
                                     std::filesystem::perms::owner_read);
    }
    std::string file() const { return folder_ / "t.toml"; }

    const TemporaryFolder folder_;
};

TEST_F(MavlinkKeys, AreTakenBothWays) {
    EXPECT_EQ(to_autopilot("key = \"drone.key\"\nlink_id = 255\n", file()), Lines{});
    EXPECT_EQ(from_autopilot("key = \"drone.key\"\n", file()), Lines{});
}

/// 105 bytes at 57600 baud take 18.2 ms, 79 take 13.7.
TEST_F(MavlinkKeys, MakeFramesLongerThanAShortPeriod) {
    EXPECT_EQ(to_autopilot("period = \"14ms\"\n"), Lines{});
    const Lines mistakes = to_autopilot("period = \"18ms\"\nkey = \"drone.key\"\n", file());
    ASSERT_EQ(mistakes.size(), 1U);
    EXPECT_NE(mistakes[0].find("shorter than a frame"), std::string::npos) << mistakes[0];
}

TEST_F(MavlinkKeys, NeedVersion2) {
    EXPECT_EQ(to_autopilot("message = \"rc_channels_override\"\nversion = 1\nkey = "
                           "\"drone.key\"\n",
                           file()),
              Lines{file() + ":9:7: \"key\" has no effect with MAVLink 1, which has no "
                             "signatures; leave it out, or version = 2"});
}

TEST_F(MavlinkKeys, AreNeededForTheLinkInThem) {
    EXPECT_EQ(to_autopilot("link_id = 1\n"),
              Lines{"t.toml:7:11: \"link_id\" has no effect without \"key\"; leave it out"});
}

}  // namespace
}  // namespace tribus::test::mavlink_protocol_test
