#include "app/init/attachment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "tests/unit/app/init/examined_places.h"
#include "transports/codecs/dronecan/dronecan.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/native_can/channels.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/registry/registry.h"

namespace tribus::init::test::attachment_test {
namespace {

using doctor::LineSound;
using doctor::LineStory;

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

bool tells(const Decision& decision, std::string_view id) {
    return std::ranges::find(decision.findings, id, &doctor::Finding::id) !=
           decision.findings.end();
}

std::string refusal_of(const Decision& decision) {
    return decision.attachment ? "it was not refused" : decision.attachment.error();
}

std::string parse_error(std::string_view text, SettingScope way) {
    const auto option = parse_place_option(text, way);
    return option ? "it was not refused" : option.error();
}

TEST(InitPlace, MayNameAProtocol) {
    const auto option = parse_place_option("/dev/ttyUSB0=ibus", SettingScope::input);
    ASSERT_TRUE(option) << option.error();
    EXPECT_EQ(option->place, "/dev/ttyUSB0");
    EXPECT_EQ(option->protocol, &kIbusProtocol);
}

TEST(InitPlace, NeedNotNameOne) {
    const auto option = parse_place_option("/dev/ttyUSB0", SettingScope::output);
    ASSERT_TRUE(option) << option.error();
    EXPECT_EQ(option->protocol, nullptr);
}

TEST(InitPlace, MayContainAnEqualsSignIfTheProtocolIsNamed) {
    const auto option = parse_place_option("/dev/serial/by-id/a=b=sbus", SettingScope::input);
    ASSERT_TRUE(option) << option.error();
    EXPECT_EQ(option->place, "/dev/serial/by-id/a=b");
}

TEST(InitPlace, WithAMisspeltProtocolGetsTheNearestName) {
    EXPECT_TRUE(has(parse_error("can0=dronecam", SettingScope::output),
                    "there is no protocol \"dronecam\"; did you mean \"dronecan\"?"));
}

TEST(InitPlace, MustNotBeMissing) {
    EXPECT_TRUE(has(parse_error("=ibus", SettingScope::input),
                    "there must be a serial device or a CAN interface"));
    EXPECT_TRUE(has(parse_error("", SettingScope::input),
                    "there must be a serial device or a CAN interface"));
}

TEST(InitPlace, AcceptsEveryProtocolWithoutRequiredKeysAndRefusesTheOthersWithAReason) {
    for (const SettingScope way : {SettingScope::input, SettingScope::output}) {
        const auto offered = offered_protocols(way);
        for (const Protocol* protocol : protocols()) {
            const std::string text = "x=" + std::string(protocol->name);
            const bool is_offered = std::ranges::find(offered, protocol) != offered.end();
            EXPECT_EQ(parse_place_option(text, way).has_value(), is_offered) << text;
        }
    }
    EXPECT_TRUE(
        has(parse_error("can0=dbc", SettingScope::output),
            "dbc needs the keys dbc and signals, which only you know; allowed here: ibus, "));
    EXPECT_TRUE(has(parse_error("can0=sensors", SettingScope::input),
                    "sensors cannot be an input; allowed: ibus"));
}

TEST(InitPlace, WithTheProtocolOfAGamepadNamesTheCommandThatPrintsItsLines) {
    EXPECT_TRUE(
        has(parse_error("/dev/input/event5=gamepad", SettingScope::input),
            "gamepad runs on an input device only, and `init` writes lines for serial "
            "devices, SPI ports and CAN interfaces; `tribus learn DEVICE` prints the lines of a "
            "gamepad; allowed here: "));
    EXPECT_TRUE(has(parse_error("x=joystick", SettingScope::output),
                    "tribus.toml(5) describes its keys; allowed here: "));
}

TEST(InitPlace, ThatIsNoPortIsRefusedAsWhatItIs) {
    const ExaminedPlace pad{.name = "/dev/input/event5",
                            .node = "/dev/input/event5",
                            .kind = {},
                            .other_end = "this is an input device"};
    EXPECT_FALSE(pad.usable());
    for (const Protocol* named : {static_cast<const Protocol*>(nullptr), &kSbusProtocol}) {
        EXPECT_EQ(refusal_of(decide_input(pad, named)), "this is an input device");
        EXPECT_EQ(refusal_of(decide_output(pad, named, "")), "this is an input device");
    }
}

TEST(InitInput, HasTheProtocolThatWasHeard) {
    const Decision decision = decide_input(with_story(free_port("0"), heard_ibus(18)), nullptr);
    ASSERT_TRUE(decision.attachment) << decision.attachment.error();
    EXPECT_EQ(decision.attachment->protocol, &kIbusProtocol);
    EXPECT_EQ(decision.attachment->name, "/dev/serial/by-id/usb-FTDI_0");
    EXPECT_EQ(decision.attachment->channels, 18U);
    ASSERT_EQ(decision.attachment->remarks.size(), 1U);
    EXPECT_TRUE(has(decision.attachment->remarks[0], "Heard: i.Bus, 18 channels, 115200 baud 8N1"));
    EXPECT_TRUE(decision.findings.empty());
}

/// The line.scale_unknown of doctor says what to do.
TEST(InitInput, HasNoRemarkAboutAScaleThatIsNotKnown) {
    LineStory story = heard_ibus();
    story.scale.reason = "the scale cannot be determined from these values";
    const Decision decision = decide_input(with_story(free_port("0"), story), nullptr);
    ASSERT_TRUE(decision.attachment) << decision.attachment.error();
    EXPECT_EQ(decision.attachment->remarks.size(), 1U);
}

TEST(InitInput, HasTheKeysWhoseDefaultsDoNotFitTheLine) {
    LineStory story = heard_sbus();
    story.line = doctor::kFastSbusLine;
    story.scale = {"futaba", "it rests at 1024"};
    story.period = std::chrono::milliseconds(80);
    const Decision decision = decide_input(with_story(free_port("0"), story), nullptr);
    ASSERT_TRUE(decision.attachment) << decision.attachment.error();
    std::string keys;
    for (const doctor::HeardKey& heard : decision.attachment->keys) {
        keys += std::string(heard.key) + "=" + heard.value + " ";
    }
    EXPECT_EQ(keys, "baud=200000 scale=\"futaba\" timeout=\"240ms\" ");
    EXPECT_EQ(decision.attachment->remarks.back(), "Scale: it rests at 1024");
}

TEST(InitInput, ThatOnlyLacksAnInverterOrParityIsAcceptedWithAFinding) {
    for (const LineSound sound : {LineSound::inverted, LineSound::wrong_parity}) {
        LineStory story = heard_sbus();
        story.sound = sound;
        const Decision decision = decide_input(
            with_problem(with_story(free_port("0"), story), "line.inverted", "inverted"), nullptr);
        ASSERT_TRUE(decision.attachment) << decision.attachment.error();
        EXPECT_EQ(decision.attachment->protocol, &kSbusProtocol);
        EXPECT_TRUE(tells(decision, "line.inverted"));
    }
}

TEST(InitInput, ThatIsSilentIsAcceptedOnlyIfItsProtocolIsNamed) {
    const LineStory silence;
    const ExaminedPlace examined =
        with_problem(with_story(free_port("0"), silence), "line.silence", "silent");
    EXPECT_EQ(refusal_of(decide_input(examined, nullptr)), "nothing was heard");
    const Decision named = decide_input(examined, &kIbusProtocol);
    ASSERT_TRUE(named.attachment) << named.attachment.error();
    EXPECT_TRUE(tells(named, "line.silence"));
    EXPECT_TRUE(named.attachment->remarks.empty());
}

TEST(InitInput, ThatCarriesNoiseIsRefused) {
    LineStory story;
    story.sound = LineSound::unknown;
    EXPECT_EQ(refusal_of(decide_input(with_story(free_port("0"), story), nullptr)),
              "no known protocol was heard");
}

TEST(InitInput, ThatIsInUseIsAcceptedOnlyIfItsProtocolIsNamed) {
    const ExaminedPlace examined =
        with_problem(free_port("0"), "port.in_use", "it is in use by cat");
    const Decision decision = decide_input(examined, nullptr);
    EXPECT_EQ(refusal_of(decision), "it is in use by cat");
    EXPECT_TRUE(tells(decision, "port.in_use"));
    EXPECT_TRUE(decide_input(examined, &kSbusProtocol).attachment);
}

TEST(InitInput, OnTheSensorBusIsRefused) {
    LineStory story = heard_ibus();
    story.protocol = "ibus-sensor";
    EXPECT_TRUE(has(refusal_of(decide_input(with_story(free_port("0"), story), nullptr)),
                    "has no channels; connect the receiver's SERVO output"));
}

TEST(InitInput, ThatCarriesAnotherProtocolThanWasNamedGetsAFinding) {
    const Decision decision =
        decide_input(with_story(free_port("0"), heard_ibus()), &kSbusProtocol);
    ASSERT_TRUE(decision.attachment) << decision.attachment.error();
    EXPECT_EQ(decision.attachment->protocol, &kSbusProtocol);
    EXPECT_TRUE(decision.attachment->keys.empty());
    EXPECT_EQ(decision.attachment->channels, 0U);
    EXPECT_TRUE(tells(decision, "line.other_protocol"));
}

TEST(InitInput, OnAnInterfaceHasTheNativeFormatUnlessAProtocolIsNamed) {
    const Decision usual = decide_input(interface_named("can0"), nullptr);
    ASSERT_TRUE(usual.attachment) << usual.attachment.error();
    EXPECT_EQ(usual.attachment->protocol, &kCanProtocol);
    const Decision named = decide_input(interface_named("can0"), &kDroneCanProtocol);
    ASSERT_TRUE(named.attachment) << named.attachment.error();
    EXPECT_EQ(named.attachment->protocol, &kDroneCanProtocol);
}

TEST(InitPort, ThatDoesNotExistIsAcceptedOnlyWithAProtocolOfCan) {
    ExaminedPlace examined =
        with_problem(interface_named("can7"), "can.unknown", "no such interface");
    examined.known = false;
    EXPECT_TRUE(has(refusal_of(decide_output(examined, nullptr, "")), "a serial device is a path"));
    EXPECT_TRUE(has(refusal_of(decide_input(examined, nullptr)), "a serial device is a path"));
    EXPECT_TRUE(
        has(refusal_of(decide_input(examined, &kIbusProtocol)), "a serial device is a path"));
    EXPECT_TRUE(decide_input(examined, &kCanProtocol).attachment);
    EXPECT_TRUE(decide_output(examined, &kCanProtocol, "").attachment);
}

TEST(InitPort, HasSbusIfItIsAnSpiPort) {
    const Decision usual = decide_input(spi_port(), nullptr);
    ASSERT_TRUE(usual.attachment) << usual.attachment.error();
    EXPECT_EQ(usual.attachment->protocol, &kSbusProtocol);
    EXPECT_TRUE(decide_output(spi_port(), nullptr, "").attachment);
    EXPECT_TRUE(has(refusal_of(decide_input(spi_port(), &kIbusProtocol)),
                    "ibus does not run on an SPI port; sbus does"));
}

TEST(InitPort, MustHaveTheKindOfLinkOfItsProtocol) {
    EXPECT_TRUE(has(refusal_of(decide_input(free_port("0"), &kCanProtocol)),
                    "can runs on a CAN interface"));
    EXPECT_TRUE(has(refusal_of(decide_output(interface_named("can0"), &kSbusProtocol, "")),
                    "sbus runs on a serial device"));
}

TEST(InitPort, ThatIsNotASerialDeviceIsRefusedWithAnyProtocol) {
    const ExaminedPlace examined =
        with_problem(free_port("0"), "port.not_serial", "this is not a serial device");
    EXPECT_EQ(refusal_of(decide_input(examined, &kIbusProtocol)), "this is not a serial device");
    EXPECT_EQ(refusal_of(decide_output(examined, nullptr, "")), "this is not a serial device");
}

TEST(InitPort, GetsANoteOnlyIfItExplainsARefusal) {
    ExaminedPlace examined = mini_uart();
    examined.findings.push_back({doctor::Severity::note, "port.mini_uart", "", "mini", "", ""});
    examined.findings.push_back(
        {doctor::Severity::note, "port.receive_trigger", "", "later", "", ""});
    EXPECT_TRUE(decide_output(examined, &kIbusProtocol, "").findings.empty());
    const Decision refused = decide_output(examined, &kSbusProtocol, "");
    EXPECT_TRUE(tells(refused, "port.mini_uart"));
    EXPECT_FALSE(tells(refused, "port.receive_trigger"));
}

TEST(InitOutput, HasSbusOrTheNativeFormatUnlessAProtocolIsNamed) {
    const Decision serial = decide_output(free_port("1"), nullptr, "");
    ASSERT_TRUE(serial.attachment) << serial.attachment.error();
    EXPECT_EQ(serial.attachment->protocol, &kSbusProtocol);
    const Decision can = decide_output(interface_named("can0"), nullptr, "");
    ASSERT_TRUE(can.attachment) << can.attachment.error();
    EXPECT_EQ(can.attachment->protocol, &kCanProtocol);
}

TEST(InitOutput, WhosePortCanNeverRunItIsRefused) {
    EXPECT_EQ(refusal_of(decide_output(mini_uart(), nullptr, "")), "it has no parity bit");
    EXPECT_TRUE(decide_output(mini_uart(), &kIbusProtocol, "").attachment);
    EXPECT_EQ(refusal_of(decide_output(free_port("1"), nullptr, "asked for 100000 baud")),
              "asked for 100000 baud");
}

TEST(InitOutput, WhosePortIsInUseIsAcceptedWithAFinding) {
    const ExaminedPlace examined =
        with_problem(free_port("1"), "port.login", "a login waits on it");
    const Decision decision = decide_output(examined, nullptr, "");
    ASSERT_TRUE(decision.attachment) << decision.attachment.error();
    EXPECT_TRUE(tells(decision, "port.login"));
}

TEST(InitOutput, OnThePortOfAnInputMustHaveTheSameRate) {
    const Attachment input = *decide_input(free_port("0"), &kIbusProtocol).attachment;
    EXPECT_TRUE(has(port_conflict({input}, *decide_output(free_port("0"), nullptr, "").attachment),
                    "a port has one rate and parity, and those of ibus and sbus differ"));
    EXPECT_EQ(port_conflict({input}, *decide_output(free_port("0"), &kIbusProtocol, "").attachment),
              "");
    EXPECT_EQ(port_conflict({input}, *decide_output(free_port("1"), nullptr, "").attachment), "");
}

}  // namespace
}  // namespace tribus::init::test::attachment_test
