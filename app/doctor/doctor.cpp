#include "app/doctor/doctor.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/streams.h"
#include "app/doctor/can_judge.h"
#include "app/doctor/examine.h"
#include "app/doctor/facts/gpio_facts.h"
#include "app/doctor/facts/input_facts.h"
#include "app/doctor/facts/kernel_files.h"
#include "app/doctor/facts/port_users.h"
#include "app/doctor/facts/pwm_facts.h"
#include "app/doctor/facts/spi_facts.h"
#include "app/doctor/machine_judge.h"
#include "app/doctor/report.h"
#include "app/journal/terminal_stream.h"
#include "config/schema/notation.h"
#include "core/quotes.h"
#include "pipelines/realtime/clock.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/links/evdev/evdev_link.h"
#include "transports/links/gpio/gpio_line.h"
#include "transports/links/spi/spi_loopback.h"
#include "transports/links/spi/spi_port.h"

namespace tribus {
namespace {

using namespace doctor;

constexpr Duration kShortest = std::chrono::seconds(1);
constexpr Duration kLongest = std::chrono::seconds(60);

struct DoctorOptions {
    std::vector<std::string> devices;
    std::string listening = "3s";
    std::string format = "text";
    bool loopback = false;
};

void append(std::vector<Finding>& to, std::vector<Finding> more) {
    std::ranges::move(more, std::back_inserter(to));
}

void take_can(Report& report, const std::string& name, bool asked_for) {
    const auto interface = query_can_interface(name);
    if (interface) {
        append(report.findings, judge_can(*interface, asked_for));
        report.can.push_back(*interface);
    } else {
        report.findings.push_back(unknown_interface(name, interface.error()));
    }
}

void take_port(const KernelFiles& files, const std::string& device, Duration time, Report& report) {
    const bool terminal = ::isatty(STDERR_FILENO) == 1;
    ExaminedPort port = examine_port(files, device, time, [&](std::string_view words) {
        if (terminal) {
            tell_person(fmt::format("{}: {}", device, words));
        }
    });
    append(report.findings, port.opinion.findings);
    report.ports.push_back(std::move(port));
}

/// Opens a gamepad that may be opened, to see whether another program has taken it.
void take_input(const KernelFiles& files, const std::string& device, Report& report) {
    InputFacts facts = look_at_input(files, device);
    if (facts.device.is_gamepad() && facts.access.may_open) {
        const std::string& node = facts.device.node;
        const auto link = EvdevLink::open(node, true);
        facts.refusal = link ? "" : link.error().substr(node.size() + std::strlen(": "));
    }
    append(report.findings, judge_input(facts, true));
    report.inputs.push_back(std::move(facts));
}

void take_pwm(const KernelFiles& files, const std::string& device, Report& report) {
    std::vector<PwmFacts> chips = look_at_pwm_chip(files, device);
    if (chips.empty()) {
        report.findings.push_back(unknown_pwm_chip(files, device));
    }
    for (PwmFacts& facts : chips) {
        append(report.findings, judge_pwm(facts, true));
        report.pwm.push_back(std::move(facts));
    }
}

void take_uinput(const KernelFiles& files, bool asked_for, Report& report) {
    report.uinput = look_at_uinput(files);
    append(report.findings, judge_uinput(*report.uinput, asked_for));
}

void take_gpio(const std::string& device, std::span<const GpioChip> chips, Report& report) {
    const std::string path = gpio_chip_path(device);
    append(report.findings, judge_gpio(device, path, chips));
    if (auto facts = look_at_gpio(device, path, chips)) {
        report.gpio.push_back(std::move(*facts));
    }
}

/// Sends frames by a wire between the data lines of the port.
void try_loopback(SpiFacts& facts) {
    constexpr int kFrames = 1000;
    const auto tried = try_spi_loopback(facts.device, kSbusProtocol.line, kFrames, monotonic_now);
    if (tried) {
        facts.loopback = *tried;
    } else {
        facts.refusal = tried.error().substr(facts.device.size() + 2);
    }
}

/// Opens a port that nobody has open, to see whether it takes its settings. Sends nothing unless
/// the user asks for it.
void take_spi_port(const KernelFiles& files, const std::string& device, bool loopback,
                   Report& report) {
    SpiFacts facts = look_at_spi_port(files, device);
    facts.users = users_of(files, facts.device).users;
    if (facts.access.may_open && facts.users.empty()) {
        facts.refusal = why_no_spi_port(facts.device, SpiUse::listens);
        if (facts.refusal->empty()) {
            facts.no_output = why_no_spi_port(facts.device, SpiUse::draws);
        }
        if (loopback && facts.refusal->empty() && facts.no_output.empty()) {
            try_loopback(facts);
        }
    }
    append(report.findings, judge_spi_port(facts, true));
    report.spi.push_back(std::move(facts));
}

/// Returns whether the device is one at the ends of a pipeline that is no wire.
bool take_other_end(const KernelFiles& files, const std::string& device, Report& report) {
    if (names_input(files, device)) {
        take_input(files, device, report);
    } else if (names_pwm_chip(files, device)) {
        take_pwm(files, device, report);
    } else if (device == "/dev/uinput" || device == "uinput") {
        take_uinput(files, true, report);
    } else if (names_spi_port(device)) {
        take_spi_port(files, device, false, report);
    } else if (const auto chips = find_gpio_chips().value_or(std::vector<GpioChip>{});
               names_gpio(device, chips)) {
        take_gpio(device, chips, report);
    } else {
        return false;
    }
    return true;
}

void take_device(const KernelFiles& files, const std::string& device, Duration time,
                 const std::vector<std::string>& can, Report& report) {
    const bool interface = device.find('/') == std::string::npos;
    const bool known = std::ranges::find(can, device) != can.end();
    if (!known && take_other_end(files, device, report)) {
        return;
    }
    if (interface && !known && std::filesystem::exists("/dev/" + device)) {
        take_port(files, "/dev/" + device, time, report);
    } else if (interface) {
        take_can(report, device, true);
    } else {
        take_port(files, device, time, report);
    }
}

void take_everything(const KernelFiles& files, Report& report) {
    report.machine = look_at_machine(files);
    append(report.findings, judge_machine(*report.machine));
    for (SerialFacts& facts : look_at_serial_ports(files)) {
        ExaminedPort port{.facts = std::move(facts)};
        port.opinion = judge_port(port.facts, false);
        append(report.findings, port.opinion.findings);
        report.ports.push_back(std::move(port));
    }
    for (const std::string& name : can_interfaces(files)) {
        take_can(report, name, false);
    }
    for (InputFacts& facts : look_at_gamepads(files)) {
        append(report.findings, judge_input(facts, false));
        report.inputs.push_back(std::move(facts));
    }
    for (PwmFacts& facts : look_at_pwm_chips(files)) {
        append(report.findings, judge_pwm(facts, false));
        report.pwm.push_back(std::move(facts));
    }
    take_uinput(files, false, report);
    for (GpioChip& chip : find_gpio_chips().value_or(std::vector<GpioChip>{})) {
        append(report.findings, judge_gpio_chip(chip));
        if (chip.error == 0) {
            report.gpio.push_back({std::move(chip), {}});
        }
    }
    for (SpiFacts& facts : look_at_spi_ports(files)) {
        append(report.findings, judge_spi_port(facts, false));
        report.spi.push_back(std::move(facts));
    }
}

std::string text_for_people(const Report& report) {
    return report_text(report, text_columns(STDOUT_FILENO), shows_colour(STDOUT_FILENO));
}

int examine(const DoctorOptions& options) {
    const auto time = parse_duration(options.listening);
    if (!time || *time < kShortest || *time > kLongest) {
        return complain(fmt::format("--for {}: must be a time from {} to {}, such as 3s",
                                    in_quotes(options.listening), format_duration(kShortest),
                                    format_duration(kLongest)),
                        kExitWrongUse);
    }
    const auto no_spi_port = std::ranges::find_if_not(options.devices, names_spi_port);
    if (options.loopback && (options.devices.empty() || no_spi_port != options.devices.end())) {
        return complain(
            "--loopback: only for SPI ports; name them, such as tribus doctor --loopback "
            "/dev/spidev0.0",
            kExitWrongUse);
    }
    const KernelFiles files("/");
    Report report;
    const std::vector<std::string> can = can_interfaces(files);
    for (const std::string& device : options.devices) {
        if (options.loopback) {
            take_spi_port(files, device, true, report);
            continue;
        }
        take_device(files, device, *time, can, report);
    }
    if (options.devices.empty()) {
        take_everything(files, report);
    }
    std::ranges::stable_sort(report.findings, {}, &Finding::severity);
    fmt::print("{}", options.format == "json" ? report_json(report) : text_for_people(report));
    const bool problems =
        !report.findings.empty() && report.findings.front().severity == Severity::problem;
    return problems ? kExitFailed : kExitFine;
}

}  // namespace

Command doctor_command() {
    const auto options = std::make_shared<DoctorOptions>();
    return {
        .name = "doctor",
        .help = "Check what ports and machine can do, what arrives, and what to fix",
        .notes =
            "A device that another program has open is not opened. Nothing is written to a device, "
            "except with --loopback. "
            "But opening it raises its control lines, which restarts some boards (Arduino), and "
            "the kernel may echo a byte that arrives at that moment, as it may with `run`.",
        .options = {{.name = "DEVICE",
                     .value = &options->devices,
                     .help = "Serial devices to try and listen to, CAN interfaces, gamepads, PWM "
                             "chips, GPIO lines, SPI ports, /dev/uinput; default: check all of "
                             "them and the machine, without opening any"},
                    {.name = "--for",
                     .value = &options->listening,
                     .help = "How long to listen to each device",
                     .shows_value = true,
                     .value_name = "DURATION"},
                    {.name = "--loopback",
                     .value = &options->loopback,
                     .help = "With nothing but a wire from MOSI to MISO of an SPI port: send 1,000 "
                             "frames of SBUS and read them back"},
                    {.name = "--format",
                     .value = &options->format,
                     .help = "json: one object",
                     .shows_value = true,
                     .choices = {"text", "json"}}},
        .examples = {{"tribus doctor", "all ports and the machine, without opening any"},
                     {"tribus doctor --for 5s /dev/ttyAMA5",
                      "with a receiver attached: which protocol arrives there, and how well"}},
        .exits = {{kExitFine, "no problems"}, {kExitFailed, "problems found, or the work failed"}},
        .run = [options] { return examine(*options); },
    };
}

}  // namespace tribus
