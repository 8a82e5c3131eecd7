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

TEST_F(SerialPorts, are_those_with_hardware) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    tree.port("ttyS0", "platform/serial8250", "serial8250");
    tree.write("sys/class/tty/ttyS0/type", "0\n");
    tree.write("sys/class/tty/tty1/dev", "4:1\n");
    tree.port("hvc0", "virtio0", "virtio_console");
    EXPECT_EQ(names(), std::vector<std::string>{"ttyAMA0"});
}

TEST_F(SerialPorts, pl011_does_everything) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    const PortOpinion opinion = asked_for("/dev/ttyAMA0");
    EXPECT_EQ(abilities(opinion), kAll);
    EXPECT_EQ(opinion.kind, "PL011 of the board");
    EXPECT_TRUE(opinion.findings.empty());
}

TEST_F(SerialPorts, pl011_reads_sbus_through_an_inverter_only) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    EXPECT_EQ(asked_for("/dev/ttyAMA0").abilities[1].because, "through an inverter");
}

TEST_F(SerialPorts, driver_is_found_below_the_layers_of_linux_6_5) {
    tree.port("ttyAMA5", "soc/fe201400.serial/fe201400.serial:0/fe201400.serial:0.0", "port");
    tree.link("sys/devices/soc/fe201400.serial/fe201400.serial:0/fe201400.serial:0.0/subsystem",
              "sys/bus/serial-base");
    tree.link("sys/devices/soc/fe201400.serial/fe201400.serial:0/driver", "sys/bus/drivers/ctrl");
    tree.link("sys/devices/soc/fe201400.serial/fe201400.serial:0/subsystem", "sys/bus/serial-base");
    tree.link("sys/devices/soc/fe201400.serial/driver", "sys/bus/drivers/uart-pl011");
    EXPECT_EQ(facts_of("/dev/ttyAMA5").driver, "uart-pl011");
}

TEST_F(SerialPorts, mini_uart_has_no_parity) {
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

TEST_F(SerialPorts, mini_uart_is_told_by_the_device_tree_alone) {
    tree.port("ttyS0", "soc/fe215040.serial", "of_serial");
    tree.write("sys/devices/soc/fe215040.serial/of_node/compatible", "brcm,bcm2835-aux-uart");
    EXPECT_EQ(abilities(asked_for("/dev/ttyS0")), kNoSbus);
}

TEST_F(SerialPorts, pc_16550_runs_at_115200_instead_of_100000) {
    tree.port("ttyS0", "pnp0/00:04", "serial");
    tree.write("sys/class/tty/ttyS0/type", "4\n");
    tree.write("sys/class/tty/ttyS0/uartclk", "1843200\n");
    const PortOpinion opinion = asked_for("/dev/ttyS0");
    EXPECT_EQ(abilities(opinion), kNoSbus);
    EXPECT_EQ(opinion.abilities[1].because, "it would run at 115200 baud");
}

TEST_F(SerialPorts, beaglebone_clock_divides_down_to_100000) {
    tree.port("ttyS4", "ocp/481a8000.serial", "omap8250");
    tree.write("sys/class/tty/ttyS4/type", "4\n");
    tree.write("sys/class/tty/ttyS4/uartclk", "48000000\n");
    EXPECT_EQ(abilities(asked_for("/dev/ttyS4")), kAll);
}

TEST_F(SerialPorts, driver_that_may_set_its_clock_is_not_judged_by_it) {
    tree.port("ttyS3", "soc/fe670000.serial", "dw-apb-uart");
    tree.write("sys/class/tty/ttyS3/type", "4\n");
    tree.write("sys/class/tty/ttyS3/uartclk", "1843200\n");
    EXPECT_EQ(abilities(asked_for("/dev/ttyS3")), kSbusUnknown);
}

TEST_F(SerialPorts, jetson_uart_says_what_was_asked_for_whatever_it_does) {
    tree.port("ttyTHS1", "soc/3100000.serial", "serial-tegra");
    const PortOpinion opinion = asked_for("/dev/ttyTHS1");
    EXPECT_EQ(abilities(opinion), kSbusUnknown);
    EXPECT_NE(opinion.abilities[1].because.find("dmesg"), std::string::npos);
}

TEST_F(SerialPorts, ftdi_does_everything) {
    tree.usb_port("ttyUSB0", "ftdi_sio", "FT232R USB UART", "0600");
    const PortOpinion opinion = asked_for("/dev/ttyUSB0");
    EXPECT_EQ(opinion.kind, "USB adapter, FTDI FT232R");
    EXPECT_EQ(abilities(opinion), kAll);
}

TEST_F(SerialPorts, usb_adapter_is_late_as_a_sensor) {
    tree.usb_port("ttyUSB0", "ftdi_sio", "FT232R USB UART", "0600");
    EXPECT_NE(asked_for("/dev/ttyUSB0").abilities[3].because.find("late"), std::string::npos);
}

TEST_F(SerialPorts, ftdi_that_holds_bytes_back_is_told) {
    tree.usb_port("ttyUSB0", "ftdi_sio", "FT232R USB UART", "0600");
    tree.write("sys/devices/usb1/1-1/1-1:1.0/ttyUSB0/latency_timer", "16\n");
    const PortOpinion opinion = asked_for("/dev/ttyUSB0");
    ASSERT_NE(found(opinion, "port.latency_timer"), nullptr);
    EXPECT_NE(found(opinion, "port.latency_timer")->what.find("16 ms"), std::string::npos);
}

TEST_F(SerialPorts, ftdi_that_keeps_its_long_timer_is_to_be_set_by_hand) {
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

TEST_F(SerialPorts, ftdi_with_the_short_timer_is_well) {
    tree.usb_port("ttyUSB0", "ftdi_sio", "FT232R USB UART", "0600");
    tree.write("sys/devices/usb1/1-1/1-1:1.0/ttyUSB0/latency_timer", "1\n");
    EXPECT_TRUE(asked_for("/dev/ttyUSB0").findings.empty());
}

TEST_F(SerialPorts, old_cp2102_makes_115200_of_100000) {
    tree.usb_port("ttyUSB0", "cp210x", "CP2102 USB to UART Bridge Controller", "0100");
    const PortOpinion opinion = asked_for("/dev/ttyUSB0");
    EXPECT_EQ(abilities(opinion), kNoSbus);
    EXPECT_EQ(opinion.abilities[1].because, "it sets 115200 baud instead of 100000");
    EXPECT_EQ(ids(opinion), std::vector<std::string>{"port.quantised_rates"});
}

TEST_F(SerialPorts, cp2102n_sets_any_rate) {
    tree.usb_port("ttyUSB0", "cp210x", "CP2102N USB to UART Bridge Controller", "0100");
    EXPECT_EQ(abilities(asked_for("/dev/ttyUSB0")), kAll);
}

TEST_F(SerialPorts, second_port_of_a_cp2105_takes_its_rates_from_a_table) {
    tree.usb_port("ttyUSB0", "cp210x", "CP2105 Dual USB to UART Bridge Controller", "0100");
    EXPECT_EQ(abilities(asked_for("/dev/ttyUSB0")), kAll);
    tree.write("sys/devices/usb1/1-1/1-1:1.0/bInterfaceNumber", "01\n");
    EXPECT_EQ(abilities(asked_for("/dev/ttyUSB0")), kNoSbus);
}

TEST_F(SerialPorts, cp210x_that_does_not_say_which_is_unknown) {
    tree.usb_port("ttyUSB0", "cp210x", "Flight Computer", "0100");
    EXPECT_EQ(abilities(asked_for("/dev/ttyUSB0")), kSbusUnknown);
}

TEST_F(SerialPorts, ch340_sets_any_rate_by_its_driver) {
    tree.usb_port("ttyUSB0", "ch341-uart", "USB2.0-Serial", "0254");
    EXPECT_EQ(abilities(asked_for("/dev/ttyUSB0")), kAll);
    EXPECT_NE(asked_for("/dev/ttyUSB0").abilities[1].because.find("not tried"), std::string::npos);
}

TEST_F(SerialPorts, pl2303_is_unknown) {
    tree.usb_port("ttyUSB0", "pl2303", "USB-Serial Controller", "0300");
    EXPECT_EQ(abilities(asked_for("/dev/ttyUSB0")), kSbusUnknown);
}

TEST_F(SerialPorts, rates_of_a_modem_device_are_its_firmwares) {
    tree.usb_port("ttyACM0", "cdc_acm", "Pico", "0100");
    EXPECT_EQ(abilities(asked_for("/dev/ttyACM0")), kSbusUnknown);
}

TEST_F(SerialPorts, adapter_is_named_by_what_it_is) {
    tree.usb_port("ttyUSB0", "ftdi_sio", "FT232R USB UART", "0600");
    tree.plain_link("dev/serial/by-id/usb-FTDI_FT232R-if00-port0", "../../ttyUSB0");
    EXPECT_EQ(facts_of("/dev/ttyUSB0").device, "/dev/serial/by-id/usb-FTDI_FT232R-if00-port0");
}

TEST_F(SerialPorts, adapter_is_known_by_its_link) {
    tree.usb_port("ttyUSB0", "ftdi_sio", "FT232R USB UART", "0600");
    tree.plain_link("dev/serial/by-id/usb-FTDI_FT232R-if00-port0", "../../ttyUSB0");
    EXPECT_EQ(facts_of("/dev/serial/by-id/usb-FTDI_FT232R-if00-port0").node, "/dev/ttyUSB0");
}

TEST_F(SerialPorts, device_that_is_not_there_is_a_problem) {
    const PortOpinion opinion = asked_for("/dev/ttyUSB7");
    ASSERT_EQ(ids(opinion), std::vector<std::string>{"port.missing"});
    EXPECT_EQ(opinion.findings[0].severity, Severity::problem);
    EXPECT_EQ(opinion.findings[0].where, "/dev/ttyUSB7");
}

TEST_F(SerialPorts, file_is_not_serial) {
    tree.write("dev/random", "");
    EXPECT_EQ(ids(asked_for("/dev/random")), std::vector<std::string>{"port.not_serial"});
}

TEST_F(SerialPorts, node_without_a_uart_is_a_problem) {
    tree.port("ttyS5", "platform/serial8250", "serial8250");
    tree.write("sys/class/tty/ttyS5/type", "0\n");
    EXPECT_EQ(ids(asked_for("/dev/ttyS5")), std::vector<std::string>{"port.no_hardware"});
}

TEST_F(SerialPorts, port_of_another_group_needs_that_group) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    SerialFacts facts = facts_of("/dev/ttyAMA0");
    facts.may_open = false;
    facts.group = "dialout";
    const PortOpinion opinion = judge_port(facts, true);
    ASSERT_EQ(ids(opinion), std::vector<std::string>{"port.permission"});
    EXPECT_EQ(opinion.findings[0].commands,
              std::vector<std::string>{"sudo usermod -aG dialout $USER"});
}

TEST_F(SerialPorts, port_of_root_alone_needs_a_rule) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    SerialFacts facts = facts_of("/dev/ttyAMA0");
    facts.may_open = false;
    facts.group = "root";
    EXPECT_NE(judge_port(facts, true).findings[0].fix.find("KERNEL==\"ttyAMA0\""),
              std::string::npos);
}

TEST_F(SerialPorts, kernel_console_is_found_in_the_command_line) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    tree.port("ttyAMA01", "soc/fe201001.serial", "uart-pl011");
    tree.write("proc/cmdline", "quiet console=ttyAMA0,115200 root=/dev/mmcblk0p2\n");
    EXPECT_EQ(ids(asked_for("/dev/ttyAMA0")), std::vector<std::string>{"port.kernel_console"});
    EXPECT_TRUE(asked_for("/dev/ttyAMA01").findings.empty());
}

TEST_F(SerialPorts, kernel_console_is_found_where_the_kernel_chose_it) {
    tree.port("ttyS0", "pnp0/00:04", "serial");
    tree.write("sys/class/tty/ttyS0/console", "Y\n");
    EXPECT_EQ(ids(asked_for("/dev/ttyS0")), std::vector<std::string>{"port.kernel_console"});
}

TEST_F(SerialPorts, login_is_named_with_what_ends_it) {
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

TEST_F(SerialPorts, program_that_has_it_open_is_named) {
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

TEST_F(SerialPorts, uart_that_waits_for_more_bytes_is_told) {
    tree.port("ttyS0", "pnp0/00:04", "serial");
    tree.write("sys/class/tty/ttyS0/rx_trig_bytes", "8\n");
    const PortOpinion opinion = asked_for("/dev/ttyS0");
    ASSERT_EQ(ids(opinion), std::vector<std::string>{"port.receive_trigger"});
    EXPECT_EQ(opinion.findings[0].severity, Severity::note);
}

TEST_F(SerialPorts, hindrances_of_a_port_that_nobody_asked_for_are_advice) {
    tree.port("ttyAMA0", "soc/fe201000.serial", "uart-pl011");
    tree.write("proc/cmdline", "console=ttyAMA0\n");
    const PortOpinion opinion = judge_port(facts_of("/dev/ttyAMA0"), false);
    ASSERT_EQ(ids(opinion), std::vector<std::string>{"port.kernel_console"});
    EXPECT_EQ(opinion.findings[0].severity, Severity::advice);
}

}  // namespace
}  // namespace tribus::doctor::serial_test
