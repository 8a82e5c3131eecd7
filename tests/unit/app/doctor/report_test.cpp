#include "app/doctor/report.h"

#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "app/doctor/line_advice.h"
#include "config/load.h"

namespace tribus::doctor::report_test {
namespace {

using std::chrono::milliseconds;

LineStory heard(LineSound sound, std::string_view protocol, const LineSettings& line) {
    LineStory story;
    story.sound = sound;
    story.protocol = protocol;
    story.line = line;
    story.listened = std::chrono::seconds(3);
    story.bytes = 12'800;
    story.frames = 400;
    story.period = milliseconds(7);
    story.channels = 18;
    return story;
}

std::vector<std::string> ids(const LineStory& story) {
    std::vector<std::string> all;
    for (const Finding& finding : judge_story(story, "/dev/ttyAMA5")) {
        all.emplace_back(finding.id);
    }
    return all;
}
using Ids = std::vector<std::string>;

std::string text_of(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) {
        text += line + "\n";
    }
    return text;
}

/// Returns the mistakes of a configuration with these lines and everything else that it needs.
std::string mistakes_with(const std::vector<std::string>& lines) {
    const bool input = lines.front().starts_with("[input");
    const std::string rest =
        input ? "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyAMA9\"\n"
                "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
              : "";
    const auto loaded = load_configuration(text_of(lines) + rest, "doctor.toml");
    return loaded ? "" : loaded.error().front().text;
}

TEST(DoctorsLines, AreThreeForIbus) {
    const LineStory story = heard(LineSound::frames, "ibus", kIbusLine);
    const auto lines = configuration_lines(story, "/dev/ttyAMA5");
    EXPECT_EQ(text_of(lines),
              "[input.receiver]\nprotocol = \"ibus\"\ndevice   = \"/dev/ttyAMA5\"\n");
    EXPECT_EQ(mistakes_with(lines), "");
}

TEST(DoctorsLines, HaveTheRateAndTheScaleOfFastSbus) {
    LineStory story = heard(LineSound::frames, "sbus", kFastSbusLine);
    story.scale.name = "futaba";
    const auto lines = configuration_lines(story, "/dev/serial/by-id/usb-FTDI");
    EXPECT_EQ(text_of(lines),
              "[input.receiver]\nprotocol = \"sbus\"\ndevice   = \"/dev/serial/by-id/usb-FTDI\"\n"
              "baud     = 200000\nscale    = \"futaba\"\n");
    EXPECT_EQ(mistakes_with(lines), "");
}

TEST(DoctorsLines, HaveALongerTimeoutForASlowSender) {
    LineStory story = heard(LineSound::frames, "sbus", kSbusLine);
    story.period = milliseconds(81);
    const auto lines = configuration_lines(story, "/dev/ttyAMA5");
    EXPECT_EQ(lines.back(), "timeout  = \"250ms\"");
    EXPECT_EQ(mistakes_with(lines), "");
}

TEST(DoctorsLines, AreValidForEveryScale) {
    for (const std::string_view scale : {"betaflight", "frsky", "futaba", "px4", "ardupilot"}) {
        LineStory story = heard(LineSound::frames, "sbus", kSbusLine);
        story.scale.name = scale;
        EXPECT_EQ(mistakes_with(configuration_lines(story, "/dev/ttyAMA5")), "") << scale;
    }
}

TEST(DoctorsLines, AreAWholeConfigurationForASensorBus) {
    const auto lines =
        configuration_lines(heard(LineSound::frames, "ibus-sensor", kIbusLine), "/dev/ttyAMA4");
    EXPECT_EQ(mistakes_with(lines), "");
}

TEST(DoctorsLines, AreThoseBehindTheInverterForAnInvertedLine) {
    const auto lines =
        configuration_lines(heard(LineSound::inverted, "sbus", kSbusLine), "/dev/ttyAMA5");
    EXPECT_EQ(mistakes_with(lines), "");
}

TEST(DoctorsLines, AreNoneWhereNothingCanBeRead) {
    for (const LineSound sound : {LineSound::silence, LineSound::wrong_parity, LineSound::breaks,
                                  LineSound::ibus2, LineSound::sbus24, LineSound::unknown}) {
        EXPECT_TRUE(configuration_lines(heard(sound, "sbus", kSbusLine), "/dev/x").empty());
    }
}

TEST(DoctorsLines, QuoteWhateverADeviceIsCalled) {
    const auto lines = configuration_lines(heard(LineSound::frames, "ibus", kIbusLine),
                                           "/dev/serial/by-id/a\"b\\c");
    EXPECT_EQ(mistakes_with(lines), "");
}

TEST(DoctorsWords, GoodLineHasNoFinding) {
    EXPECT_EQ(ids(heard(LineSound::frames, "ibus", kIbusLine)), Ids{});
}

TEST(DoctorsWords, EachSoundHasItsFinding) {
    EXPECT_EQ(ids(heard(LineSound::silence, "", kIbusLine)), Ids{"line.silence"});
    EXPECT_EQ(ids(heard(LineSound::inverted, "sbus", kSbusLine)), Ids{"line.inverted"});
    EXPECT_EQ(ids(heard(LineSound::wrong_parity, "sbus", kSbusLine)), Ids{"line.wrong_parity"});
    EXPECT_EQ(ids(heard(LineSound::breaks, "", kSbusLine)), Ids{"line.low"});
    EXPECT_EQ(ids(heard(LineSound::ibus2, "", kIbusLine)), Ids{"line.ibus2"});
    EXPECT_EQ(ids(heard(LineSound::sbus24, "", kSbusLine)), Ids{"line.sbus24"});
    EXPECT_EQ(ids(heard(LineSound::unknown, "", kIbusLine)), Ids{"line.unknown"});
}

TEST(DoctorsWords, InvertedIbusWantsItsInverterOutAndSbusOneIn) {
    const auto fix = [](std::string_view protocol, const LineSettings& line) {
        return judge_story(heard(LineSound::inverted, protocol, line), "/dev/x")[0].fix;
    };
    EXPECT_TRUE(fix("ibus", kIbusLine).starts_with("i.Bus needs no inverter: remove it"));
    EXPECT_TRUE(fix("sbus", kSbusLine).starts_with("Put an inverter between"));
}

TEST(DoctorsWords, OneByteInAHundredOutsideOfFramesIsADisturbance) {
    LineStory story = heard(LineSound::frames, "ibus", kIbusLine);
    story.lost_bytes = 128;
    EXPECT_EQ(ids(story), Ids{});
    story.lost_bytes = 129;
    EXPECT_EQ(ids(story), Ids{"line.disturbed"});
}

TEST(DoctorsWords, ReceiverWithoutItsTransmitterIsTold) {
    LineStory story = heard(LineSound::frames, "sbus", kSbusLine);
    story.scale.name = "futaba";
    story.failsafe = story.frame_lost = story.frames;
    EXPECT_EQ(ids(story), Ids{"line.failsafe"});
    story.failsafe = 0;
    EXPECT_EQ(ids(story), Ids{"line.frame_lost"});
}

TEST(DoctorsWords, SensorsOnTheWireAreTold) {
    LineStory story = heard(LineSound::frames, "ibus-sensor", kIbusLine);
    story.requests = 400;
    story.replies = 390;
    EXPECT_EQ(ids(story), Ids{"line.sensors_answer"});
    story = heard(LineSound::frames, "ibus", kIbusLine);
    story.requests = 400;
    EXPECT_EQ(ids(story), Ids{"line.shared"});
}

Report report_of(LineSound sound) {
    ExaminedPort port;
    port.facts.node = "/dev/ttyUSB0";
    port.facts.device = "/dev/serial/by-id/usb-FTDI_FT232R_USB_UART_A50285BI-if00-port0";
    port.opinion.kind = "USB adapter, FTDI FT232R";
    port.opinion.abilities = {{"i.Bus", Ability::yes, ""},
                              {"SBUS", Ability::no, "it would run at 115200 baud"}};
    port.tried = true;
    port.story = heard(sound, "sbus", kSbusLine);
    port.story->scale = {"futaba", "12 channels rest at 1024"};
    port.lines = configuration_lines(*port.story, port.facts.device);
    Report report;
    report.findings = judge_story(*port.story, port.facts.node);
    report.ports.push_back(std::move(port));
    return report;
}

TEST(DoctorsReport, FitsANarrowTerminalButForWhatIsCopied) {
    for (const LineSound sound : {LineSound::silence, LineSound::frames, LineSound::inverted,
                                  LineSound::wrong_parity, LineSound::breaks, LineSound::unknown}) {
        std::istringstream lines(report_text(report_of(sound), 80, false));
        for (std::string line; std::getline(lines, line);) {
            EXPECT_TRUE(line.size() <= 80 || line.find("by-id") != std::string::npos) << line;
        }
    }
}

TEST(DoctorsReport, HasColoursOnlyWhereTheyAreWanted) {
    EXPECT_EQ(report_text(report_of(LineSound::inverted), 80, false).find('\x1b'),
              std::string::npos);
    EXPECT_NE(report_text(report_of(LineSound::inverted), 80, true).find("\x1b[31mproblem"),
              std::string::npos);
}

TEST(DoctorsReport, SaysThePortThenWhatIsToBeMended) {
    const std::string text = report_text(report_of(LineSound::inverted), 80, false);
    EXPECT_TRUE(text.starts_with(
        "/dev/ttyUSB0: USB adapter, FTDI FT232R\n"
        "  name     /dev/serial/by-id/usb-FTDI_FT232R_USB_UART_A50285BI-if00-port0\n"
        "  takes    i.Bus\n"
        "  cannot   SBUS (it would run at 115200 baud)\n"
        "  hears    SBUS at 100000 baud, inverted, each 7.00 ms\n"
        "  For the configuration, when that is fixed:\n"
        "    [input.receiver]\n"))
        << text;
    EXPECT_NE(text.find("\nproblem  /dev/ttyUSB0: SBUS is on it, but inverted [line.inverted]\n"),
              std::string::npos)
        << text;
}

TEST(DoctorsReport, IsOneObjectForPrograms) {
    const auto json = nlohmann::json::parse(report_json(report_of(LineSound::inverted)));
    EXPECT_EQ(json["ports"][0]["heard"]["sound"], "inverted");
    EXPECT_EQ(json["ports"][0]["heard"]["protocol"], "sbus");
    EXPECT_EQ(json["ports"][0]["heard"]["line"]["baud"], 100000);
    EXPECT_EQ(json["ports"][0]["abilities"][1]["can"], "no");
    EXPECT_EQ(json["findings"][0]["id"], "line.inverted");
    EXPECT_EQ(json["findings"][0]["severity"], "problem");
    EXPECT_TRUE(json["machine"].is_null());
}

}  // namespace
}  // namespace tribus::doctor::report_test
