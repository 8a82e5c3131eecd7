#include <gtest/gtest.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "app/doctor/facts/gpio_facts.h"
#include "app/doctor/facts/input_facts.h"
#include "app/doctor/facts/pwm_facts.h"
#include "app/doctor/facts/spi_facts.h"
#include "app/doctor/report.h"
#include "tests/support/input_tree.h"
#include "tests/unit/config/main_job.h"

/// What doctor sees of gamepads, of uinput, of PWM chips, of GPIO lines and of SPI ports.
namespace tribus::doctor::other_ends_test {
namespace {

using Ids = std::vector<std::string>;

Ids ids(const std::vector<Finding>& findings) {
    Ids all;
    for (const Finding& finding : findings) {
        all.emplace_back(finding.id);
    }
    return all;
}

class OtherEnds : public testing::Test {
  protected:
    KernelFiles files() const { return KernelFiles(tree_.root()); }
    InputFacts input(const std::string& device) const { return look_at_input(files(), device); }
    static InputFacts forbidden(InputFacts facts, const std::string& group) {
        facts.access = {.exists = true, .may_open = false, .group = group};
        return facts;
    }
    void add_chip(const std::string& name, const std::string& driver, int outputs) const {
        const std::string chip = "sys/class/pwm/" + name + "/";
        tree_.plain_link(chip + "device/driver", "../../../bus/platform/drivers/" + driver);
        tree_.write(chip + "npwm", std::to_string(outputs) + "\n");
        tree_.write(chip + "export", "");
    }
    void take(const std::string& chip, int output, const std::string& pulse, bool on) const {
        const std::string folder = "sys/class/pwm/" + chip + "/pwm" + std::to_string(output) + "/";
        tree_.write(folder + "duty_cycle", pulse + "\n");
        tree_.write(folder + "period", "20000000\n");
        tree_.write(folder + "enable", on ? "1\n" : "0\n");
    }

    test::InputTree tree_;
};

TEST_F(OtherEnds, AreTheGamepadsAmongTheInputDevicesWithTheirStableNames) {
    tree_.add_keyboard("event0");
    tree_.add_pad("event5", "Pad");
    tree_.plain_link("dev/input/by-id/usb-Pad-event-joystick", "../event5");
    const auto pads = look_at_gamepads(files());
    ASSERT_EQ(pads.size(), 1U);
    EXPECT_EQ(describe(pads[0]), "gamepad \"Pad\", 4 axes, 3 buttons");
    EXPECT_EQ(judge_input(pads[0], false).size(), 0U);
    EXPECT_EQ(pads[0].device.device, "/dev/input/by-id/usb-Pad-event-joystick");
}

TEST_F(OtherEnds, HaveLinesThatAConfigurationTakes) {
    tree_.add_pad("event5", "Pad");
    std::string text;
    for (const std::string& line : configuration_lines(input("/dev/input/event5"))) {
        text += line + "\n";
    }
    const Configuration configuration =
        test::loaded(text +
                     "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n"
                     "[pipeline.main]\nfrom = \"pad\"\nto = \"servos\"\n");
    EXPECT_EQ(configuration.inputs.at(0).port.device, "/dev/input/event5");
}

TEST_F(OtherEnds, WithoutANameThatStaysGetARuleByAddressElseByName) {
    tree_.add_pad("event5", "Pad");
    const auto by_name = judge_input(input("/dev/input/event5"), true);
    ASSERT_EQ(ids(by_name), (Ids{"input.no_stable_name"}));
    EXPECT_EQ(by_name[0].severity, Severity::advice);
    EXPECT_NE(by_name[0].fix.find("ATTRS{name}==\"Pad\", SYMLINK+=\"input/pad\""),
              std::string::npos)
        << by_name[0].fix;
    tree_.write("sys/class/input/event5/device/uniq", "a0:b1:c2:d3:e4:f5\n");
    const auto by_address = judge_input(input("/dev/input/event5"), true);
    EXPECT_NE(by_address[0].fix.find("ATTRS{uniq}==\"a0:b1:c2:d3:e4:f5\""), std::string::npos)
        << by_address[0].fix;
}

TEST_F(OtherEnds, ThatAreNoGamepadsAreProblemsWhenTheyWereNamed) {
    tree_.add_keyboard("event0");
    tree_.write("dev/input/js0", "");
    EXPECT_EQ(ids(judge_input(input("/dev/input/by-id/none"), true)), (Ids{"input.missing"}));
    EXPECT_EQ(ids(judge_input(input("/dev/input/js0"), true)), (Ids{"input.old_device"}));
    const auto keyboard = judge_input(input("/dev/input/event0"), true);
    ASSERT_EQ(ids(keyboard), (Ids{"input.no_gamepad"}));
    EXPECT_EQ(keyboard[0].what, "\"Keyboard\" is no gamepad and no joystick");
    EXPECT_EQ(keyboard[0].severity, Severity::problem);
}

TEST_F(OtherEnds, ThatMayNotBeReadNameTheGroupOrARule) {
    tree_.add_pad("event5", "Pad");
    tree_.plain_link("dev/input/by-id/pad", "../event5");
    const InputFacts facts = input("/dev/input/by-id/pad");
    const auto group = judge_input(forbidden(facts, "input"), true);
    ASSERT_EQ(ids(group), (Ids{"input.permission"}));
    EXPECT_EQ(group[0].severity, Severity::problem);
    EXPECT_EQ(group[0].commands, (Ids{"sudo usermod -aG input $USER"}));
    const auto root = judge_input(forbidden(facts, "root"), false);
    EXPECT_EQ(root.at(0).severity, Severity::advice);
    EXPECT_NE(root[0].fix.find("GROUP=\"input\""), std::string::npos) << root[0].fix;
}

TEST_F(OtherEnds, ThatOtherProgramsHaveAreToldWithTheirNames) {
    tree_.add_pad("event5", "Pad");
    tree_.plain_link("dev/input/by-id/pad", "../event5");
    tree_.process(41, "Xorg", "/dev/input/event5");
    tree_.process(42, "other", "/dev/input/event6");
    InputFacts facts = input("/dev/input/by-id/pad");
    facts.refusal = "another program has taken it for itself";
    const auto findings = judge_input(facts, true);
    ASSERT_EQ(ids(findings), (Ids{"input.cannot_open", "input.in_use"}));
    EXPECT_EQ(findings[0].what, "another program has taken it for itself");
    EXPECT_EQ(findings[1].what, "it is open in Xorg (process 41)");
    EXPECT_EQ(findings[1].severity, Severity::note);
}

TEST_F(OtherEnds, AreToldFromSerialDevicesByTheirPaths) {
    tree_.add_pad("event5", "Pad");
    tree_.plain_link("dev/pad", "input/event5");
    tree_.write("dev/ttyUSB0", "");
    add_chip("pwmchip2", "pca9685-pwm", 16);
    EXPECT_TRUE(names_input(files(), "/dev/input/by-id/none"));
    EXPECT_TRUE(names_input(files(), "/dev/pad"));
    EXPECT_FALSE(names_input(files(), "/dev/ttyUSB0"));
    EXPECT_FALSE(names_input(files(), "can0"));
    for (const char* chip : {"pwmchip2", "pca9685-pwm", "/sys/class/pwm/pwmchip2", "pwmchip9"}) {
        EXPECT_TRUE(names_pwm_chip(files(), chip)) << chip;
    }
    for (const char* other : {"can0", "/dev/ttyUSB0", "uinput"}) {
        EXPECT_FALSE(names_pwm_chip(files(), other)) << other;
    }
}

TEST_F(OtherEnds, NeedTheModuleAndTheGroupForVirtualJoysticks) {
    const auto missing = judge_uinput(look_at_uinput(files()), true);
    ASSERT_EQ(ids(missing), (Ids{"uinput.missing"}));
    EXPECT_EQ(missing[0].commands.front(), "sudo modprobe uinput");
    EXPECT_EQ(judge_uinput(look_at_uinput(files()), false)[0].severity, Severity::note)
        << "most machines need none";
    tree_.write("dev/uinput", "");
    EXPECT_EQ(judge_uinput(look_at_uinput(files()), true).size(), 0U);
    const auto group = judge_uinput({.access = {.exists = true, .group = "uinput"}}, true);
    ASSERT_EQ(ids(group), (Ids{"uinput.permission"}));
    EXPECT_EQ(group[0].commands, (Ids{"sudo usermod -aG uinput $USER"}));
}

TEST_F(OtherEnds, AreChipsWithWhatTheirOutputsDoForServos) {
    add_chip("pwmchip10", "pwm-bcm2835", 2);
    add_chip("pwmchip2", "pca9685-pwm", 16);
    take("pwmchip2", 0, "1500000", true);
    take("pwmchip2", 3, "0", false);
    const auto chips = look_at_pwm_chips(files());
    ASSERT_EQ(chips.size(), 2U);
    EXPECT_EQ(chips[0].chip.name, "pwmchip2");
    const auto findings = judge_pwm(chips[0], false);
    ASSERT_EQ(ids(findings), (Ids{"pwm.taken", "pwm.on"}));
    EXPECT_EQ(findings[0].what, "taken, and off: output 3");
    EXPECT_EQ(findings[1].what, "sending pulses: output 0");
    EXPECT_EQ(judge_pwm(chips[1], false).size(), 0U);
}

TEST_F(OtherEnds, NameTheGroupOrTheRuleForServosThatMayNotBeUsed) {
    PwmFacts facts{.chip = {.folder = {}, .name = "pwmchip0", .driver = "pwm", .outputs = 1}};
    facts.access = {.exists = true, .may_open = false, .group = "gpio"};
    const auto group = judge_pwm(facts, true);
    ASSERT_EQ(ids(group), (Ids{"pwm.permission"}));
    EXPECT_EQ(group[0].severity, Severity::problem);
    EXPECT_EQ(group[0].commands, (Ids{"sudo usermod -aG gpio $USER"}));
    facts.access.group = "root";
    const auto root = judge_pwm(facts, false);
    EXPECT_EQ(root.at(0).severity, Severity::advice);
    EXPECT_EQ(root[0].commands,
              (Ids{"sudo udevadm trigger --action=change --subsystem-match=pwm"}));
}

TEST_F(OtherEnds, SayWhichServosAreThere) {
    add_chip("pwmchip2", "pca9685-pwm", 16);
    EXPECT_EQ(look_at_pwm_chip(files(), "pca9685-pwm").size(), 1U);
    EXPECT_EQ(look_at_pwm_chip(files(), "pwmchip0").size(), 0U);
    const Finding finding = unknown_pwm_chip(files(), "pwmchip0");
    EXPECT_EQ(finding.severity, Severity::problem);
    EXPECT_EQ(finding.what, "there is no such PWM chip; this machine has pwmchip2 (pca9685-pwm)");
}

TEST_F(OtherEnds, AreInTheReportForPeopleAndForPrograms) {
    tree_.add_pad("event5", "Pad");
    tree_.plain_link("dev/input/by-id/usb-Pad", "../event5");
    tree_.write("dev/uinput", "");
    add_chip("pwmchip2", "pca9685-pwm", 16);
    take("pwmchip2", 0, "1500000", true);
    Report report;
    report.inputs = look_at_gamepads(files());
    report.inputs[0].refusal = "";
    report.pwm = look_at_pwm_chips(files());
    report.uinput = look_at_uinput(files());
    EXPECT_EQ(report_text(report, 80, false),
              "/dev/input/event5: gamepad \"Pad\", 4 axes, 3 buttons\n"
              "  name     /dev/input/by-id/usb-Pad\n"
              "  For the configuration; `tribus learn /dev/input/by-id/usb-Pad` finds which\n"
              "  stick and button is which channel:\n"
              "    [input.pad]\n"
              "    protocol = \"gamepad\"\n"
              "    device   = \"/dev/input/by-id/usb-Pad\"\n"
              "PWM chip pwmchip2  pca9685-pwm, outputs 0 to 15\n"
              "  output  0  on     1500.0 us each 20.000 ms\n"
              "/dev/uinput: virtual joysticks are possible\n");
    const auto json = nlohmann::json::parse(report_json(report));
    EXPECT_EQ(json["inputs"][0]["device"], "/dev/input/by-id/usb-Pad");
    EXPECT_EQ(json["inputs"][0]["axes"], 4);
    EXPECT_EQ(json["inputs"][0]["gamepad"], true);
    EXPECT_EQ(json["pwm"][0]["driver"], "pca9685-pwm");
    EXPECT_EQ(json["pwm"][0]["outputs"], 16);
    EXPECT_EQ(json["pwm"][0]["taken"][0]["pulse_us"], 1500);
    EXPECT_EQ(json["uinput"]["may_open"], true);
}

std::vector<GpioChip> two_chips() {
    return {{.path = "/dev/gpiochip0",
             .lines = {{.name = "ID_SDA", .used = true, .consumer = "kernel"},
                       {.name = "GPIO17"},
                       {.name = ""}}},
            {.path = "/dev/gpiochip1", .error = EACCES}};
}

TEST(GpioEnds, AreChipsAndLinesByTheirNames) {
    for (const char* name : {"gpiochip0", "/dev/gpiochip0", "gpiochip0:17", "GPIO99", "ID_SDA"}) {
        EXPECT_TRUE(names_gpio(name, two_chips())) << name;
    }
    for (const char* other : {"can0", "/dev/ttyUSB0", "ttyAMA0", "SDA", ""}) {
        EXPECT_FALSE(names_gpio(other, two_chips())) << other;
    }
}

TEST(GpioEnds, ThatAreFreeGetLinesForAConfiguration) {
    const auto chips = two_chips();
    EXPECT_TRUE(judge_gpio("GPIO17", "", chips).empty());
    Report report;
    report.gpio.push_back(*look_at_gpio("GPIO17", "", chips));
    EXPECT_EQ(report_text(report, 80, false),
              "/dev/gpiochip0: GPIO chip with 3 lines, 1 of them in use\n"
              "  line   1  GPIO17               free\n"
              "  For the configuration:\n"
              "    [input.trainer]\n"
              "    protocol = \"ppm\"\n"
              "    line     = \"GPIO17\"\n");
    const auto unnamed = look_at_gpio("gpiochip0:2", "/dev/gpiochip0", chips);
    ASSERT_TRUE(unnamed);
    EXPECT_EQ(configuration_lines(*unnamed).back(), "line     = \"gpiochip0:2\"");
}

TEST(GpioEnds, ThatAreInUseAreAProblemWithTheirUser) {
    const auto findings = judge_gpio("ID_SDA", "", two_chips());
    ASSERT_EQ(ids(findings), (Ids{"gpio.in_use"}));
    EXPECT_EQ(findings[0].severity, Severity::problem);
    EXPECT_NE(findings[0].what.find("in use by \"kernel\""), std::string::npos);
    const auto facts = look_at_gpio("ID_SDA", "", two_chips());
    ASSERT_TRUE(facts);
    EXPECT_TRUE(configuration_lines(*facts).empty());
}

TEST(GpioEnds, AreListedWhenTheirChipIsNamed) {
    const auto facts = look_at_gpio("gpiochip0", "/dev/gpiochip0", two_chips());
    ASSERT_TRUE(facts);
    EXPECT_EQ(facts->asked, (std::vector<unsigned>{0, 1, 2}));
    EXPECT_TRUE(judge_gpio("gpiochip0", "/dev/gpiochip0", two_chips()).empty());
    EXPECT_TRUE(configuration_lines(*facts).empty());
}

TEST(GpioEnds, ThatAreNotThereOrRefusedAreProblemsWhenTheyWereNamed) {
    const auto chips = two_chips();
    EXPECT_EQ(ids(judge_gpio("GPIO99", "", chips)), (Ids{"gpio.missing"}));
    EXPECT_EQ(ids(judge_gpio("gpiochip7", "/dev/gpiochip7", chips)), (Ids{"gpio.missing"}));
    EXPECT_EQ(ids(judge_gpio("gpiochip0:3", "/dev/gpiochip0", chips)), (Ids{"gpio.missing"}));
    EXPECT_EQ(ids(judge_gpio("gpiochip1:3", "/dev/gpiochip1", chips)), (Ids{"gpio.permission"}));
    const std::span refused(&chips[1], 1);
    EXPECT_EQ(ids(judge_gpio("GPIO17", "", refused)), (Ids{"gpio.permission"}));
    EXPECT_EQ(ids(judge_gpio("GPIO17", "", {})), (Ids{"gpio.missing"}));
    EXPECT_EQ(judge_gpio("GPIO17", "", {}).front().severity, Severity::problem);
}

TEST(GpioEnds, ThatNobodyAskedForAreNotesAtMost) {
    const auto chips = two_chips();
    EXPECT_TRUE(judge_gpio_chip(chips[0]).empty());
    const auto findings = judge_gpio_chip(chips[1]);
    ASSERT_EQ(ids(findings), (Ids{"gpio.permission"}));
    EXPECT_EQ(findings[0].severity, Severity::note);
    EXPECT_EQ(findings[0].where, "/dev/gpiochip1");
}

TEST_F(OtherEnds, AreSpiPortsWithTheLinesOfAnOutputForSbus) {
    tree_.write("dev/spidev0.1", "");
    tree_.write("dev/spidev0.0", "");
    tree_.write("dev/spi0", "");
    const auto ports = look_at_spi_ports(files());
    ASSERT_EQ(ports.size(), 2U);
    EXPECT_EQ(ports[0].device, "/dev/spidev0.0");
    Report report;
    report.spi.push_back(look_at_spi_port(files(), "spidev0.1"));
    report.spi[0].refusal = "";
    EXPECT_TRUE(judge_spi_port(report.spi[0], true).empty());
    EXPECT_EQ(report_text(report, 80, false),
              "/dev/spidev0.1: SPI port; its data lines can be those of SBUS without an\n"
              "inverter (out by MOSI, or in by MISO), and MOSI can make PPM\n"
              "  For the configuration:\n"
              "    [output.servos]\n"
              "    protocol = \"sbus\"\n"
              "    spi      = \"/dev/spidev0.1\"\n");
    const auto json = nlohmann::json::parse(report_json(report));
    EXPECT_EQ(json["spi"][0]["device"], "/dev/spidev0.1");
    EXPECT_EQ(json["spi"][0]["refusal"], "");
}

TEST_F(OtherEnds, SayWhatToDoForAnSpiPortThatCannotBeUsed) {
    SpiFacts facts = look_at_spi_port(files(), "/dev/spidev3.0");
    EXPECT_EQ(ids(judge_spi_port(facts, true)), (Ids{"spi.missing"}));
    facts.access = {.exists = true, .may_open = false, .group = "spi"};
    const auto findings = judge_spi_port(facts, true);
    ASSERT_EQ(ids(findings), (Ids{"spi.permission"}));
    EXPECT_EQ(findings[0].commands, (std::vector<std::string>{"sudo usermod -aG spi $USER"}));
    EXPECT_EQ(judge_spi_port(facts, false).front().severity, Severity::note);
    facts.access = {.exists = true, .may_open = true};
    facts.refusal = "";
    facts.no_output = "the data line of its controller rests high";
    EXPECT_EQ(ids(judge_spi_port(facts, true)), (Ids{"spi.cannot_draw"}));
    EXPECT_EQ(configuration_lines(facts).front(), "[input.receiver]");
    facts.users = {{.process = 812, .command = "tribus", .unit = {}, .is_login = false}};
    EXPECT_EQ(ids(judge_spi_port(facts, true)), (Ids{"spi.in_use"}));
    EXPECT_TRUE(configuration_lines(facts).empty());
    facts.users.clear();
    facts.refusal = "this is no SPI port";
    EXPECT_EQ(ids(judge_spi_port(facts, true)), (Ids{"spi.cannot_open"}));
    EXPECT_TRUE(configuration_lines(facts).empty());
    EXPECT_TRUE(names_spi_port("spidev0.0") && names_spi_port("/dev/spidev1.2"));
    EXPECT_FALSE(names_spi_port("/dev/ttyS0"));
}

TEST(SpiLoopbackFindings, AreNoneIfEachFrameCameBack) {
    const SpiLoopback good{.hz = 900'000,
                           .byte_before = std::chrono::nanoseconds(10'010),
                           .byte_after = std::chrono::nanoseconds(10'020),
                           .sent = 1000,
                           .right = 1000};
    EXPECT_TRUE(judge_spi_port({.device = "/dev/spidev0.0",
                                .access = {.exists = true, .may_open = true},
                                .refusal = "",
                                .loopback = good},
                               true)
                    .empty());
    EXPECT_EQ(describe(good),
              "loopback: 1000 of 1000 frames came back; at 900000 Hz a byte takes 10.010 us, 9.01 "
              "clocks; afterwards +0.1 %");
}

TEST(SpiLoopbackFindings, NameWhatIsWrong) {
    const auto found = [](SpiLoopback loopback) {
        loopback.sent = 1000;
        const SpiFacts facts{.device = "/dev/spidev0.0",
                             .access = {.exists = true, .may_open = true},
                             .refusal = "",
                             .loopback = loopback};
        return ids(judge_spi_port(facts, true));
    };
    using std::chrono::nanoseconds;
    EXPECT_EQ(found({.silent = 1000}), (Ids{"spi.no_wire"}));
    EXPECT_EQ(found({.right = 999, .silent = 0}), (Ids{"spi.frames_lost"}));
    EXPECT_EQ(
        found(
            {.byte_before = nanoseconds(10'000), .byte_after = nanoseconds(9'849), .right = 1000}),
        (Ids{"spi.drift"}));
    EXPECT_EQ(
        found(
            {.byte_before = nanoseconds(10'000), .byte_after = nanoseconds(10'150), .right = 1000}),
        (Ids{}));
}

}  // namespace
}  // namespace tribus::doctor::other_ends_test
