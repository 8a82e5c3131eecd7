#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/build/build.h"
#include "config/show/effective.h"
#include "tests/support/can_snapshots.h"
#include "tests/unit/config/main_job.h"
#include "transports/codecs/native_can/channels.h"
#include "transports/links/can/can_medium.h"
#include "transports/links/serial/serial_medium.h"

/// Inputs and outputs with protocol "can" as a user writes them.
namespace tribus::test::can_ports_test {
namespace {

using Lines = std::vector<std::string>;
using std::chrono::milliseconds;

/// Both directions in 13 lines. Each test changes one of them.
constexpr std::array<std::string_view, 13> kBusJob{
    "[input.cockpit]", "protocol = \"can\"",  "interface = \"can0\"",
    "[output.bus]",    "protocol = \"can\"",  "interface = \"can1\"",
    "[output.servos]", "protocol = \"sbus\"", "device = \"/dev/ttyB\"",
    "[pipeline.main]", "from = \"cockpit\"",  "to = [\"bus\", \"servos\"]",
    "# the last line",
};

std::string bus_job_with(std::size_t number, std::string_view replacement) {
    std::string text;
    for (std::size_t i = 0; i < kBusJob.size(); ++i) {
        text += i + 1 == number ? replacement : kBusJob[i];
        text += '\n';
    }
    return text;
}

Configuration loaded(std::string_view text) {
    const auto configuration = load_configuration(text, "t.toml");
    if (!configuration) {
        ADD_FAILURE() << format_mistake(configuration.error().front());
        return {};
    }
    return *configuration;
}

class MistakeInCanPorts : public ::testing::TestWithParam<Spoilt> {};

TEST_P(MistakeInCanPorts, IsReportedWithItsPlaceAndWhatIsAllowed) {
    const Spoilt& spoilt = GetParam();
    EXPECT_EQ(mistakes_in(bus_job_with(spoilt.line, spoilt.replacement)),
              Lines{std::string(spoilt.expected)});
}

constexpr Spoilt kMistakes[]{
    {"misspelt_interface", 3, R"(interfase = "can0")",
     R"(t.toml:3:1: unknown key "interfase" in [input.cockpit]; did you mean )"
     R"("interface"? Allowed: "protocol", "interface", "timeout", "failsafe_flag", )"
     R"("frame_lost_flag", "frame_lost_run", "frame_lost_ratio", "failsafe_when", "frozen", )"
     R"("plausible", "zero_guard", "map", )"
     R"("id", "extended", "fd", "crc", "channels", "key", "old_key", "link", "epoch")"},
    {"missing_interface", 3, "",
     R"(t.toml:1:1: [input.cockpit] lacks "interface"; required: CAN interface, such as )"
     R"("can0")"},
    {"empty_interface", 3, R"(interface = "")",
     R"(t.toml:3:13: "interface" is ""; allowed: the name of an interface, )"
     R"(1 to 15 characters without blanks, "/" and ":")"},
    {"interface_of_a_wrong_type", 3, "interface = 0",
     R"(t.toml:3:13: "interface" is 0; allowed: the name of an interface, )"
     R"(1 to 15 characters without blanks, "/" and ":")"},
    {"baud_of_a_bus", 3, R"(interface = "can0"
baud = 500000)",
     R"(t.toml:4:1: unknown key "baud" in [input.cockpit]; a CAN interface gets it from )"
     R"(Linux: sudo ip link set can0 down; sudo ip link set can0 up type can bitrate 500000)"},
    {"id_too_high_for_11_bits", 6, R"(interface = "can1"
id = 0x7FB)",
     R"(t.toml:7:6: 2043 is too high for ids of 11 bits; allowed is 0 to 2042 (0x7FA), )"
     R"(or more with extended = true)"},
    {"id_too_high_for_29_bits", 6, R"(interface = "can1"
extended = true
id = 0x1FFFFFFB)",
     R"(t.toml:8:6: "id" is 536870907; allowed: a whole number from 0 to 536870906)"},
    {"negative_id", 6, R"(interface = "can1"
id = -1)",
     R"(t.toml:7:6: "id" is -1; allowed: a whole number from 0 to 536870906)"},
    {"id_as_text", 6, R"(interface = "can1"
id = "0x300")",
     R"(t.toml:7:6: "id" is "0x300"; leave the quotes out: id = 0x300)"},
    {"extended_of_a_wrong_type", 6, R"(interface = "can1"
extended = 29)",
     R"(t.toml:7:12: "extended" is 29; allowed: true or false)"},
    {"fd_of_a_wrong_type", 6, R"(interface = "can1"
fd = "true")",
     R"(t.toml:7:6: "fd" is "true"; leave the quotes out: fd = true)"},
    {"misspelt_crc", 6, R"(interface = "can1"
crc = "p21")",
     R"(t.toml:7:7: "crc" is "p21"; did you mean "p22"? Allowed: "p22", "p01")"},
    {"crc_of_classic_frames_with_fd", 6, R"(interface = "can1"
crc = "p01"
fd = true)",
     R"(t.toml:7:7: "p01" is for classic frames; FD frames always have profile 5: leave )"
     R"(out crc, or fd)"},
    {"channels_that_are_no_choice", 6, R"(interface = "can1"
channels = 17)",
     R"(t.toml:7:12: "channels" is 17; allowed: 16, 18)"},
    {"16_channels_with_fd", 6, R"(interface = "can1"
channels = 16
fd = true)",
     R"(t.toml:7:12: 16 is for classic frames; an FD frame always has 18 channels: )"
     R"(leave out channels, or fd)"},
    {"misspelt_foreign_sender", 6, R"(interface = "can1"
foreign_sender = "ignroe")",
     R"(t.toml:7:18: "foreign_sender" is "ignroe"; did you mean "ignore"? Allowed: )"
     R"("failsafe", "ignore")"},
    {"foreign_sender_of_an_input", 3, R"(interface = "can0"
foreign_sender = "ignore")",
     R"(t.toml:4:1: unknown key "foreign_sender" in [input.cockpit]; it belongs in )"
     R"([output.NAME] with protocol "can"; allowed: "protocol", "interface", "timeout", )"
     R"("failsafe_flag", "frame_lost_flag", "frame_lost_run", "frame_lost_ratio", )"
     R"("failsafe_when", "frozen", "plausible", "zero_guard", "map", "id", "extended", "fd", )"
     R"("crc", "channels", "key", "old_key", "link", "epoch")"},
    {"foreign_sender_of_a_serial_output", 9, R"(device = "/dev/ttyB"
foreign_sender = "ignore")",
     R"(t.toml:10:1: unknown key "foreign_sender" in [output.servos]; it belongs in )"
     R"([output.NAME] with protocol "can"; allowed: "protocol", "device", "period", )"
     R"("force", "schedule", "phase", "baud", "scale", "inverted")"},
    {"id_of_a_serial_output", 9, R"(device = "/dev/ttyB"
id = 0x300)",
     R"(t.toml:10:1: unknown key "id" in [output.servos]; it belongs in )"
     R"([output.NAME] with protocol "can"; allowed: "protocol", "device", "period", )"
     R"("force", "schedule", "phase", "baud", "scale", "inverted")"},
    {"period_below_what_readers_follow", 6, R"(interface = "can1"
period = "1999us")",
     R"(t.toml:7:10: "period" is "1999us", shorter than readers of "can" can follow; )"
     R"(allowed: "2ms" to "1s", or add force = true)"},
    {"timeout_not_longer_than_the_period", 3, R"(interface = "can0"
timeout = "14ms")",
     R"(t.toml:4:11: the timeout of input "cockpit" is "14ms", but output "servos" )"
     R"(sends every "14ms": each frame would be judged too old; allowed: a timeout )"
     R"(longer than the period)"},
    {"output_on_the_ids_of_an_input", 6, R"(interface = "can0")",
     R"(t.toml:6:13: on "can0" the id 0x300 of [output.bus] is also used by [input.cockpit] in )"
     R"(line 3; allowed: ids that only one output sends and no input of the same file receives)"},
};

INSTANTIATE_TEST_SUITE_P(Mistakes, MistakeInCanPorts, ::testing::ValuesIn(kMistakes),
                         [](const auto& mistake) { return std::string(mistake.param.name); });

TEST(CanPorts, ABusHasNoDevice) {
    EXPECT_EQ(mistakes_in(bus_job_with(3, "device = \"can0\"")),
              (Lines{R"(t.toml:3:1: unknown key "device" in [input.cockpit]; protocol "can" has )"
                     R"("interface" instead: CAN interface, such as "can0")"}));
}

TEST(CanPorts, ASerialLineHasNoInterface) {
    EXPECT_EQ(
        mistakes_in(bus_job_with(9, "interface = \"/dev/ttyB\"")),
        (Lines{R"(t.toml:9:1: unknown key "interface" in [output.servos]; protocol "sbus" has )"
               R"("device" instead: Serial device, such as "/dev/ttyAMA5" or a stable name under )"
               R"(/dev/serial/by-id)" +
               other_places("sbus")}));
}

TEST(CanPorts, ADeviceBesidesTheInterfaceIsOneMistakeAndTheInterfaceIsStillJudged) {
    EXPECT_EQ(mistakes_in(bus_job_with(3, "device = \"/dev/ttyA\"\ninterface = 0")),
              (Lines{R"(t.toml:3:1: unknown key "device" in [input.cockpit]; protocol "can" has )"
                     R"("interface" instead: CAN interface, such as "can0")",
                     R"(t.toml:4:13: "interface" is 0; allowed: the name of an interface, )"
                     R"(1 to 15 characters without blanks, "/" and ":")"}));
}

TEST(CanPorts, WhatIsWrittenAsTheWrongPlaceIsNotJudgedAsTheRightOne) {
    EXPECT_EQ(mistakes_in(bus_job_with(3, "device = 0")).size(), 1U);
}

TEST(CanPorts, HaveTheDefaultsOfTheNativeFormat) {
    const Configuration configuration = loaded(bus_job_with(0, ""));
    const InputConfig& input = configuration.inputs.at(0);
    EXPECT_EQ(input.port.medium, &kCanMedium);
    EXPECT_EQ(input.port.device, "can0");
    EXPECT_EQ(input.supervision.timeout, milliseconds(100));
    const OutputConfig& output = configuration.outputs.at(0);
    EXPECT_EQ(output.schedule.period, milliseconds(10));
    EXPECT_EQ(output.foreign_sender, ForeignSender::failsafe);
    const CanChannelsFormat format = CanChannelsFormat::from_settings(output.settings);
    EXPECT_EQ(format.base_id, 0x300U);
    EXPECT_FALSE(format.extended);
    EXPECT_FALSE(format.fd);
    EXPECT_EQ(format.crc, CanChannelsCrc::p22);
    EXPECT_EQ(format.channels, 18U);
}

TEST(CanPorts, TakeAllTheirKeysFromTheFile) {
    const Configuration configuration = loaded(bus_job_with(6, R"(interface = "can1"
id = 0x1FFFFFFA
extended = true
crc = "p01"
channels = 16
period = "2ms"
foreign_sender = "ignore")"));
    const OutputConfig& output = configuration.outputs.at(0);
    EXPECT_EQ(output.schedule.period, milliseconds(2));
    EXPECT_EQ(output.foreign_sender, ForeignSender::ignore);
    const CanChannelsFormat format = CanChannelsFormat::from_settings(output.settings);
    EXPECT_EQ(format.base_id, 0x1FFFFFFAU);
    EXPECT_TRUE(format.extended);
    EXPECT_EQ(format.crc, CanChannelsCrc::p01);
    EXPECT_EQ(format.channels, 16U);
}

TEST(CanPorts, TakeTheHighestIdOf11Bits) {
    EXPECT_EQ(mistakes_in(bus_job_with(6, "interface = \"can1\"\nid = 0x7FA")), Lines{});
}

TEST(CanPorts, SayFailsafeSoTheDefaultActionIsPreset) {
    EXPECT_EQ(loaded(bus_job_with(0, "")).pipelines.at(0).failsafe.at(0).action,
              FailsafeAction::preset);
}

/// Returns the stage of the output after foreign frames among good snapshots.
OutputStage stage_after_foreign_frames(const Configuration& configuration) {
    const auto engine = build_engine(configuration);
    CanChannelsEncoder sender;
    Instant now{std::chrono::seconds(1)};
    engine->start(now);
    constexpr int kPowerOnFrames = 60;
    for (int number = 0; number < kPowerOnFrames; ++number) {
        now += milliseconds(10);
        for (const CanFrame& frame :
             test::can_frames(sender, test::numbered_snapshot(number, now), now)) {
            engine->receive(0, frame, now);
        }
        engine->poll(now);
    }
    EXPECT_EQ(engine->outputs()[0].stage(), OutputStage::control);
    CanFrame foreign;
    foreign.id = 0x302;
    for (int frame = 0; frame < 3; ++frame) {
        engine->watch_for_foreign_sender(0, foreign, now);
    }
    engine->poll(now + milliseconds(20));
    EXPECT_EQ(engine->outputs()[0].counts().foreign_frames, 3U);
    return engine->outputs()[0].stage();
}

TEST(CanPorts, AreBuiltIntoAnEngineThatYieldsToForeignSendersUnlessToldOtherwise) {
    const Configuration yielding = loaded(bus_job_with(0, ""));
    const Configuration ignoring =
        loaded(bus_job_with(6, "interface = \"can1\"\nforeign_sender = \"ignore\""));
    ASSERT_EQ(yielding.outputs.size(), 2U);
    ASSERT_EQ(ignoring.outputs.size(), 2U);
    EXPECT_EQ(stage_after_foreign_frames(yielding), OutputStage::failsafe);
    EXPECT_EQ(stage_after_foreign_frames(ignoring), OutputStage::control);
}

TEST(CanPlan, AllInputsAndOutputsOfOneInterfaceShareOnePort) {
    const Configuration configuration = loaded(R"([input.a]
protocol = "can"
interface = "can0"
[input.b]
protocol = "can"
interface = "can1"
[input.c]
protocol = "can"
interface = "can0"
id = 0x400
[output.d]
protocol = "can"
interface = "can0"
id = 0x500
[output.e]
protocol = "can"
interface = "can0"
id = 0x600
[output.f]
protocol = "sbus"
device = "can0"
[pipeline.main]
from = ["a", "b", "c"]
to = ["d", "e", "f"]
)");
    const auto plans = plan_ports(configuration);
    ASSERT_EQ(plans.size(), 3U);
    EXPECT_EQ(plans[0].config.device, "can0");
    EXPECT_EQ(plans[0].config.medium, &kCanMedium);
    using enum StationKind;
    EXPECT_EQ(plans[0].wiring.stations,
              (std::vector<Station>{{input, 0}, {input, 2}, {output, 0}, {output, 1}}));
    EXPECT_EQ(plans[1].config.device, "can1");
    EXPECT_EQ(plans[1].wiring.stations, (std::vector<Station>{{input, 1}}));
    // A serial device of the same name does not belong to that interface.
    EXPECT_EQ(plans[2].config.medium, &kSerialMedium);
    EXPECT_EQ(plans[2].wiring.stations, (std::vector<Station>{{output, 2}}));
}

TEST(CanEffective, ShowsEveryDefault) {
    const std::string text = effective_toml(loaded(bus_job_with(0, "")));
    EXPECT_NE(text.find(R"([input.cockpit]
protocol = "can"
interface = "can0"
timeout = "100ms"
failsafe_flag = true
frame_lost_flag = true
frame_lost_run = "100ms"
frame_lost_ratio = 0.9
frozen = "0s"
plausible = [800, 2200]
failsafe_when = []
id = 768
extended = false
fd = false
crc = "p22"
channels = 18
)"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find(R"([output.bus]
protocol = "can"
interface = "can1"
period = "10ms"
force = false
schedule = "follow"
phase = "free"
foreign_sender = "failsafe"
id = 768
extended = false
fd = false
crc = "p22"
channels = 18
)"),
              std::string::npos)
        << text;
}

TEST(CanEffective, LoadsAgainAndMeansTheSame) {
    for (const std::string_view lines :
         {"interface = \"can1\"", "interface = \"can1\"\nfd = true\nid = 5",
          "interface = \"can1\"\nextended = true\nid = 0x1FFFFFFA\ncrc = \"p01\"\nchannels = 16\n"
          "foreign_sender = \"ignore\"\nforce = true\nperiod = \"1ms\"\nschedule = \"grid\""}) {
        const Configuration first = loaded(bus_job_with(6, lines));
        const std::string text = effective_toml(first);
        EXPECT_EQ(mistakes_in(text), Lines{}) << text;
        const Configuration second = loaded(text);
        EXPECT_EQ(effective_toml(second), text);
        EXPECT_EQ(effective_json(second), effective_json(first));
        EXPECT_EQ(second.outputs.at(0).foreign_sender, first.outputs.at(0).foreign_sender);
    }
}

}  // namespace
}  // namespace tribus::test::can_ports_test
