#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "app/doctor/facts/serial_facts.h"
#include "app/doctor/serial_judge.h"
#include "tests/support/kernel_tree.h"

namespace tribus::doctor::serial_test {
namespace {

class SerialPorts : public testing::Test {
  protected:
    KernelFiles files() const { return KernelFiles(tree.root()); }
    std::vector<std::string> names() const {
        std::vector<std::string> found;
        for (const SerialFacts& facts : look_at_serial_ports(files())) {
            found.push_back(facts.name);
        }
        return found;
    }
    SerialFacts facts_of(const std::string& device) const {
        return look_at_serial_port(files(), device);
    }
    PortOpinion asked_for(const std::string& device) const {
        return judge_port(facts_of(device), true);
    }

    test::KernelTree tree;
};

const Finding* found(const PortOpinion& opinion, std::string_view id) {
    const auto at = std::ranges::find(opinion.findings, id, &Finding::id);
    return at == opinion.findings.end() ? nullptr : &*at;
}

std::vector<std::string> ids(const PortOpinion& opinion) {
    std::vector<std::string> all;
    for (const Finding& finding : opinion.findings) {
        all.emplace_back(finding.id);
    }
    return all;
}

/// Returns text such as "i.Bus yes, SBUS no, fast SBUS no, sensor bus yes".
std::string abilities(const PortOpinion& opinion) {
    std::string text;
    for (const PortAbility& one : opinion.abilities) {
        text += (text.empty() ? "" : ", ") + std::string(one.protocol) + " " +
                std::string(ability_name(one.ability));
    }
    return text;
}

constexpr std::string_view kAll = "i.Bus yes, SBUS yes, fast SBUS yes, sensor bus yes";
constexpr std::string_view kNoSbus = "i.Bus yes, SBUS no, fast SBUS no, sensor bus yes";
constexpr std::string_view kSbusUnknown =
    "i.Bus yes, SBUS unknown, fast SBUS unknown, sensor bus yes";

TEST_F(SerialPorts, AreThoseWithHardware) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    tree.port("ttyS0", "platform/serial8250", "serial8250");
    tree.write("sys/class/tty/ttyS0/type", "0\n");
    tree.write("sys/class/tty/tty1/dev", "4:1\n");
    tree.port("hvc0", "virtio0", "virtio_console");
    EXPECT_EQ(names(), std::vector<std::string>{"ttyAMA0"});
}

TEST_F(SerialPorts, Pl011DoesEverything) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    const PortOpinion opinion = asked_for("/dev/ttyAMA0");
    EXPECT_EQ(abilities(opinion), kAll);
    EXPECT_EQ(opinion.kind, "PL011 of the board");
    EXPECT_TRUE(opinion.findings.empty());
}

TEST_F(SerialPorts, Pl011ReadsSbusThroughAnInverterOnly) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    EXPECT_EQ(asked_for("/dev/ttyAMA0").abilities[1].because, "through an inverter");
}

TEST_F(SerialPorts, DriverIsFoundBelowTheLayersOfLinux65) {
    tree.port("ttyAMA5", "soc/fe201400.serial/fe201400.serial:0/fe201400.serial:0.0", "port");
    tree.link("sys/devices/soc/fe201400.serial/fe201400.serial:0/fe201400.serial:0.0/subsystem",
              "sys/bus/serial-base");
    tree.link("sys/devices/soc/fe201400.serial/fe201400.serial:0/driver", "sys/bus/drivers/ctrl");
    tree.link("sys/devices/soc/fe201400.serial/fe201400.serial:0/subsystem", "sys/bus/serial-base");
    tree.link("sys/devices/soc/fe201400.serial/driver", "sys/bus/drivers/uart-pl011");
    EXPECT_EQ(facts_of("/dev/ttyAMA5").driver, "uart-pl011");
}

TEST_F(SerialPorts, MiniUartHasNoParity) {
    tree.port("ttyS0", "soc/fe215040.serial", "bcm2835-aux-uart");
    tree.write("sys/devices/soc/fe215040.serial/of_node/compatible",
               std::string("brcm,bcm2835-aux-uart\0", 22));
    const PortOpinion opinion = asked_for("/dev/ttyS0");
    EXPECT_EQ(abilities(opinion), kNoSbus);
    EXPECT_EQ(opinion.abilities[1].because, "it has no parity bit");
    ASSERT_NE(found(opinion, "port.mini_uart"), nullptr);
    EXPECT_NE(found(opinion, "port.mini_uart")->fix.find("dtoverlay=disable-bt"),
              std::string::npos);
}

TEST_F(SerialPorts, MiniUartIsToldByTheDeviceTreeAlone) {
    tree.port("ttyS0", "soc/fe215040.serial", "of_serial");
    tree.write("sys/devices/soc/fe215040.serial/of_node/compatible", "brcm,bcm2835-aux-uart");
    EXPECT_EQ(abilities(asked_for("/dev/ttyS0")), kNoSbus);
}

TEST_F(SerialPorts, Pc16550RunsAt115200InsteadOf100000) {
    tree.port("ttyS0", "pnp0/00:04", "serial");
    tree.write("sys/class/tty/ttyS0/type", "4\n");
    tree.write("sys/class/tty/ttyS0/uartclk", "1843200\n");
    const PortOpinion opinion = asked_for("/dev/ttyS0");
    EXPECT_EQ(abilities(opinion), kNoSbus);
    EXPECT_EQ(opinion.abilities[1].because, "it would run at 115200 baud");
}

TEST_F(SerialPorts, BeagleboneClockDividesDownTo100000) {
    tree.port("ttyS4", "ocp/481a8000.serial", "omap8250");
    tree.write("sys/class/tty/ttyS4/type", "4\n");
    tree.write("sys/class/tty/ttyS4/uartclk", "48000000\n");
    EXPECT_EQ(abilities(asked_for("/dev/ttyS4")), kAll);
}

TEST_F(SerialPorts, DriverThatMaySetItsClockIsNotJudgedByIt) {
    tree.port("ttyS3", "soc/fe670000.serial", "dw-apb-uart");
    tree.write("sys/class/tty/ttyS3/type", "4\n");
    tree.write("sys/class/tty/ttyS3/uartclk", "1843200\n");
    EXPECT_EQ(abilities(asked_for("/dev/ttyS3")), kSbusUnknown);
}

TEST_F(SerialPorts, JetsonUartSaysWhatWasAskedForWhateverItDoes) {
    tree.port("ttyTHS1", "soc/3100000.serial", "serial-tegra");
    const PortOpinion opinion = asked_for("/dev/ttyTHS1");
    EXPECT_EQ(abilities(opinion), kSbusUnknown);
    EXPECT_NE(opinion.abilities[1].because.find("dmesg"), std::string::npos);
}

TEST_F(SerialPorts, FtdiDoesEverything) {
    tree.usb_port("ttyUSB0", "ftdi_sio", "FT232R USB UART", "0600");
    const PortOpinion opinion = asked_for("/dev/ttyUSB0");
    EXPECT_EQ(opinion.kind, "USB adapter, FTDI FT232R");
    EXPECT_EQ(abilities(opinion), kAll);
}

TEST_F(SerialPorts, UsbAdapterIsLateAsASensor) {
    tree.usb_port("ttyUSB0", "ftdi_sio", "FT232R USB UART", "0600");
    EXPECT_NE(asked_for("/dev/ttyUSB0").abilities[3].because.find("late"), std::string::npos);
}

TEST_F(SerialPorts, FtdiThatHoldsBytesBackIsTold) {
    tree.usb_port("ttyUSB0", "ftdi_sio", "FT232R USB UART", "0600");
    tree.write("sys/devices/usb1/1-1/1-1:1.0/ttyUSB0/latency_timer", "16\n");
    const PortOpinion opinion = asked_for("/dev/ttyUSB0");
    ASSERT_NE(found(opinion, "port.latency_timer"), nullptr);
    EXPECT_NE(found(opinion, "port.latency_timer")->what.find("16 ms"), std::string::npos);
}

TEST_F(SerialPorts, FtdiThatKeepsItsLongTimerIsToBeSetByHand) {
    tree.usb_port("ttyUSB0", "ftdi_sio", "FT232R USB UART", "0600");
    tree.write("sys/devices/usb1/1-1/1-1:1.0/ttyUSB0/latency_timer", "16\n");
    SerialFacts facts = facts_of("/dev/ttyUSB0");
    facts.was_opened = true;
    const PortOpinion opinion = judge_port(facts, true);
    ASSERT_EQ(ids(opinion), std::vector<std::string>{"port.latency_timer"});
    EXPECT_EQ(opinion.findings[0].severity, Severity::advice);
    EXPECT_EQ(opinion.findings[0].commands,
              std::vector<std::string>{
                  "echo 1 | sudo tee /sys/bus/usb-serial/devices/ttyUSB0/latency_timer"});
}

TEST_F(SerialPorts, FtdiWithTheShortTimerIsWell) {
    tree.usb_port("ttyUSB0", "ftdi_sio", "FT232R USB UART", "0600");
    tree.write("sys/devices/usb1/1-1/1-1:1.0/ttyUSB0/latency_timer", "1\n");
    EXPECT_TRUE(asked_for("/dev/ttyUSB0").findings.empty());
}

TEST_F(SerialPorts, OldCp2102Makes115200Of100000) {
    tree.usb_port("ttyUSB0", "cp210x", "CP2102 USB to UART Bridge Controller", "0100");
    const PortOpinion opinion = asked_for("/dev/ttyUSB0");
    EXPECT_EQ(abilities(opinion), kNoSbus);
    EXPECT_EQ(opinion.abilities[1].because, "it sets 115200 baud instead of 100000");
    EXPECT_EQ(ids(opinion), std::vector<std::string>{"port.quantised_rates"});
}

TEST_F(SerialPorts, Cp2102nSetsAnyRate) {
    tree.usb_port("ttyUSB0", "cp210x", "CP2102N USB to UART Bridge Controller", "0100");
    EXPECT_EQ(abilities(asked_for("/dev/ttyUSB0")), kAll);
}

TEST_F(SerialPorts, SecondPortOfACp2105TakesItsRatesFromATable) {
    tree.usb_port("ttyUSB0", "cp210x", "CP2105 Dual USB to UART Bridge Controller", "0100");
    EXPECT_EQ(abilities(asked_for("/dev/ttyUSB0")), kAll);
    tree.write("sys/devices/usb1/1-1/1-1:1.0/bInterfaceNumber", "01\n");
    EXPECT_EQ(abilities(asked_for("/dev/ttyUSB0")), kNoSbus);
}

TEST_F(SerialPorts, Cp210xThatDoesNotSayWhichIsUnknown) {
    tree.usb_port("ttyUSB0", "cp210x", "Flight Computer", "0100");
    EXPECT_EQ(abilities(asked_for("/dev/ttyUSB0")), kSbusUnknown);
}

TEST_F(SerialPorts, Ch340SetsAnyRateByItsDriver) {
    tree.usb_port("ttyUSB0", "ch341-uart", "USB2.0-Serial", "0254");
    EXPECT_EQ(abilities(asked_for("/dev/ttyUSB0")), kAll);
    EXPECT_NE(asked_for("/dev/ttyUSB0").abilities[1].because.find("not tried"), std::string::npos);
}

TEST_F(SerialPorts, Pl2303IsUnknown) {
    tree.usb_port("ttyUSB0", "pl2303", "USB-Serial Controller", "0300");
    EXPECT_EQ(abilities(asked_for("/dev/ttyUSB0")), kSbusUnknown);
}

TEST_F(SerialPorts, RatesOfAModemDeviceAreItsFirmwares) {
    tree.usb_port("ttyACM0", "cdc_acm", "Pico", "0100");
    EXPECT_EQ(abilities(asked_for("/dev/ttyACM0")), kSbusUnknown);
}

TEST_F(SerialPorts, AdapterIsNamedByWhatItIs) {
    tree.usb_port("ttyUSB0", "ftdi_sio", "FT232R USB UART", "0600");
    tree.plain_link("dev/serial/by-id/usb-FTDI_FT232R-if00-port0", "../../ttyUSB0");
    EXPECT_EQ(facts_of("/dev/ttyUSB0").device, "/dev/serial/by-id/usb-FTDI_FT232R-if00-port0");
}

TEST_F(SerialPorts, AdapterIsKnownByItsLink) {
    tree.usb_port("ttyUSB0", "ftdi_sio", "FT232R USB UART", "0600");
    tree.plain_link("dev/serial/by-id/usb-FTDI_FT232R-if00-port0", "../../ttyUSB0");
    EXPECT_EQ(facts_of("/dev/serial/by-id/usb-FTDI_FT232R-if00-port0").node, "/dev/ttyUSB0");
}

TEST_F(SerialPorts, DeviceThatIsNotThereIsAProblem) {
    const PortOpinion opinion = asked_for("/dev/ttyUSB7");
    ASSERT_EQ(ids(opinion), std::vector<std::string>{"port.missing"});
    EXPECT_EQ(opinion.findings[0].severity, Severity::problem);
    EXPECT_EQ(opinion.findings[0].where, "/dev/ttyUSB7");
}

TEST_F(SerialPorts, FileIsNotSerial) {
    tree.write("dev/random", "");
    EXPECT_EQ(ids(asked_for("/dev/random")), std::vector<std::string>{"port.not_serial"});
}

TEST_F(SerialPorts, NodeWithoutAUartIsAProblem) {
    tree.port("ttyS5", "platform/serial8250", "serial8250");
    tree.write("sys/class/tty/ttyS5/type", "0\n");
    EXPECT_EQ(ids(asked_for("/dev/ttyS5")), std::vector<std::string>{"port.no_hardware"});
}

TEST_F(SerialPorts, PortOfAnotherGroupNeedsThatGroup) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    SerialFacts facts = facts_of("/dev/ttyAMA0");
    facts.may_open = false;
    facts.group = "dialout";
    const PortOpinion opinion = judge_port(facts, true);
    ASSERT_EQ(ids(opinion), std::vector<std::string>{"port.permission"});
    EXPECT_EQ(opinion.findings[0].commands,
              std::vector<std::string>{"sudo usermod -aG dialout $USER"});
}

TEST_F(SerialPorts, PortOfRootAloneNeedsARule) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    SerialFacts facts = facts_of("/dev/ttyAMA0");
    facts.may_open = false;
    facts.group = "root";
    EXPECT_NE(judge_port(facts, true).findings[0].fix.find("KERNEL==\"ttyAMA0\""),
              std::string::npos);
}

TEST_F(SerialPorts, KernelConsoleIsFoundInTheCommandLine) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    tree.port("ttyAMA01", "soc/fe201001.serial", "uart-pl011");
    tree.write("proc/cmdline", "quiet console=ttyAMA0,115200 root=/dev/mmcblk0p2\n");
    EXPECT_EQ(ids(asked_for("/dev/ttyAMA0")), std::vector<std::string>{"port.kernel_console"});
    EXPECT_TRUE(asked_for("/dev/ttyAMA01").findings.empty());
}

TEST_F(SerialPorts, KernelConsoleIsFoundWhereTheKernelChoseIt) {
    tree.port("ttyS0", "pnp0/00:04", "serial");
    tree.write("sys/class/tty/ttyS0/console", "Y\n");
    EXPECT_EQ(ids(asked_for("/dev/ttyS0")), std::vector<std::string>{"port.kernel_console"});
}

TEST_F(SerialPorts, LoginIsNamedWithWhatEndsIt) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    tree.process(812, "agetty");
    tree.write("proc/812/cmdline",
               std::string("/sbin/agetty\0-o\0--keep-baud\00057600\0ttyAMA0\0vt220\0", 53));
    tree.write("proc/812/cgroup",
               "0::/system.slice/system-serial\\x2dgetty.slice/serial-getty@ttyAMA0.service\n");
    const PortOpinion opinion = asked_for("/dev/ttyAMA0");
    ASSERT_EQ(ids(opinion), std::vector<std::string>{"port.login"});
    EXPECT_EQ(
        opinion.findings[0].commands,
        std::vector<std::string>{"sudo systemctl disable --now 'serial-getty@ttyAMA0.service'"});
}

TEST_F(SerialPorts, ProgramThatHasItOpenIsNamed) {
    tree.port("ttyUSB0", "usb1/1-1/1-1:1.0/ttyUSB0", "ftdi_sio");
    tree.process(4242, "gpsd", "/dev/ttyUSB0");
    tree.process(4243, "bash", "/dev/ttyUSB1");
    tree.write("proc/4242/cgroup", "0::/system.slice/gpsd.service\n");
    const PortOpinion opinion = asked_for("/dev/ttyUSB0");
    ASSERT_EQ(ids(opinion), std::vector<std::string>{"port.in_use"});
    EXPECT_EQ(opinion.findings[0].what, "it is in use by gpsd (process 4242, gpsd.service)");
    EXPECT_EQ(opinion.findings[0].commands,
              std::vector<std::string>{"sudo systemctl stop 'gpsd.service'"});
}

TEST_F(SerialPorts, UartThatWaitsForMoreBytesIsTold) {
    tree.port("ttyS0", "pnp0/00:04", "serial");
    tree.write("sys/class/tty/ttyS0/rx_trig_bytes", "8\n");
    const PortOpinion opinion = asked_for("/dev/ttyS0");
    ASSERT_EQ(ids(opinion), std::vector<std::string>{"port.receive_trigger"});
    EXPECT_EQ(opinion.findings[0].severity, Severity::note);
}

TEST_F(SerialPorts, HindrancesOfAPortThatNobodyAskedForAreAdvice) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    tree.write("proc/cmdline", "console=ttyAMA0\n");
    const PortOpinion opinion = judge_port(facts_of("/dev/ttyAMA0"), false);
    ASSERT_EQ(ids(opinion), std::vector<std::string>{"port.kernel_console"});
    EXPECT_EQ(opinion.findings[0].severity, Severity::advice);
}

}  // namespace
}  // namespace tribus::doctor::serial_test
