#include "app/doctor/serial_judge.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "app/doctor/listening/line_heard.h"
#include "app/doctor/port_kind.h"

namespace tribus::doctor {
namespace {

constexpr std::string_view kInverter = "through an inverter";

class PortFindings {
  public:
    PortFindings(const SerialFacts& facts, bool asked_for)
        : facts_(facts), hindrance_(asked_for ? Severity::problem : Severity::advice) {}

    /// A finding that keeps the port from working.
    void hindrance(std::string_view id, std::string what, std::string why, std::string fix,
                   std::vector<std::string> commands = {}) {
        add(hindrance_, id, std::move(what), std::move(why), std::move(fix), std::move(commands));
    }
    void add(Severity severity, std::string_view id, std::string what, std::string why,
             std::string fix, std::vector<std::string> commands = {}) {
        all_.push_back({severity, id, facts_.node, std::move(what), std::move(why), std::move(fix),
                        std::move(commands)});
    }
    std::vector<Finding> take() { return std::move(all_); }

  private:
    const SerialFacts& facts_;
    Severity hindrance_;
    std::vector<Finding> all_;
};

void judge_node(const SerialFacts& facts, PortFindings& findings) {
    if (!facts.exists) {
        findings.hindrance(
            "port.missing", "there is no such device", "",
            "Is it plugged in, is its overlay loaded? These commands list the devices:",
            {"ls /dev/serial/by-id", "tribus doctor"});
        return;
    }
    if (!facts.serial) {
        findings.hindrance(
            "port.not_serial", "this is not a serial device", "",
            "Name a serial device, such as /dev/ttyUSB0; `tribus doctor` lists them.");
        return;
    }
    if (facts.uart_type == 0) {
        findings.hindrance("port.no_hardware", "the kernel found no UART behind this name", "",
                           "Enable it (on small boards by an overlay) or use another one; `tribus "
                           "doctor` lists them.");
    }
    if (!facts.may_open) {
        const bool for_group = facts.group != "root" && !facts.group.empty();
        findings.hindrance(
            "port.permission", "you may not open it",
            "Neither this program nor `tribus run` from this shell can open it; the service "
            "tribus@NAME may use ports of the group dialout.",
            for_group ? fmt::format("It belongs to the group {}. Join it, then log in again:",
                                    facts.group)
                      : std::string("It belongs to root only. A udev rule gives it to a group: "
                                    "KERNEL==\"" +
                                    facts.name + "\", GROUP=\"dialout\""),
            for_group
                ? std::vector<std::string>{fmt::format("sudo usermod -aG {} $USER", facts.group)}
                : std::vector<std::string>{});
    }
}

std::string described(const PortUser& user) {
    return user.unit.empty()
               ? fmt::format("{} (process {})", user.command, user.process)
               : fmt::format("{} (process {}, {})", user.command, user.process, user.unit);
}

void judge_login(const PortUser& user, PortFindings& findings) {
    const std::string unit = user.unit.empty() ? "serial-getty@" : user.unit;
    findings.hindrance(
        "port.login", "a login waits on it: " + described(user),
        "It writes its prompt to the servos and takes bytes of the receiver for a name and "
        "password.",
        "Disable it permanently:", {fmt::format("sudo systemctl disable --now '{}'", unit)});
}

void judge_users(std::span<const PortUser> users, PortFindings& findings) {
    constexpr std::size_t kMostNamed = 3;
    std::string names;
    std::vector<std::string> commands;
    for (const PortUser& user : users.first(std::min(users.size(), kMostNamed))) {
        names += (names.empty() ? "" : ", ") + described(user);
        if (!user.unit.empty()) {
            commands.push_back(fmt::format("sudo systemctl stop '{}'", user.unit));
        }
    }
    if (users.size() > kMostNamed) {
        names += fmt::format(" and {} more", users.size() - kMostNamed);
    }
    const bool ours = users.front().command == "tribus";
    findings.hindrance("port.in_use", "it is in use by " + names,
                       "Each byte goes to one of two readers only, and both change its settings: "
                       "it is not opened here.",
                       ours ? "`tribus monitor` shows what that program receives. To check the "
                              "port here, stop it first."
                            : "Stop that program, or use another port.",
                       std::move(commands));
}

void judge_console(const SerialFacts& facts, PortFindings& findings) {
    findings.hindrance(
        "port.kernel_console", "the kernel's console is on it",
        "Kernel messages are sent between frames, at another rate.",
        fmt::format("Remove `console={}...` from the kernel's command line and reboot: on a "
                    "Raspberry Pi in cmdline.txt (there it is called serial0; raspi-config, "
                    "Interface Options, Serial Port does it), elsewhere in /etc/default/grub or "
                    "armbianEnv.txt.",
                    facts.name));
}

void judge_hardware(const SerialFacts& facts, const PortKind& kind, PortFindings& findings) {
    if (!kind.parity) {
        findings.add(Severity::note, "port.mini_uart",
                     "this is a mini UART: without parity, with a rate that follows the core clock",
                     "SBUS is impossible, i.Bus unreliable.",
                     "The PL011 can do both: dtoverlay=disable-bt in config.txt gives it the same "
                     "pins; for i.Bus here enable_uart=1 and core_freq=250.");
    }
    if (kind.quantises_rates) {
        findings.add(Severity::note, "port.quantised_rates",
                     "this adapter sets 115200 baud instead of 100000 and 230400 instead of 200000",
                     "SBUS is impossible on it, i.Bus works.",
                     "For SBUS use an FT232R, a CP2102N or a UART of the board.");
    }
    constexpr std::int64_t kPromptTimer = 1;
    if (facts.latency_timer.value_or(kPromptTimer) > kPromptTimer) {
        findings.add(
            facts.was_opened ? Severity::advice : Severity::note, "port.latency_timer",
            fmt::format("the adapter holds bytes back for up to {} ms", *facts.latency_timer),
            facts.was_opened
                ? "It did not accept 1 ms."
                : "`tribus run` sets it to 1 ms when it opens the port; other programs may not.",
            "To set it by hand, each time after plugging it in:",
            {fmt::format("echo 1 | sudo tee /sys/bus/usb-serial/devices/{}/latency_timer",
                         facts.name)});
    }
    if (facts.receive_trigger.value_or(1) > 1) {
        findings.add(
            Severity::note, "port.receive_trigger",
            fmt::format("the UART reports received bytes in groups of {}", *facts.receive_trigger),
            "The end of a frame is reported about four characters late, 0.3 to 0.5 ms.",
            "If that matters, after each boot:",
            {fmt::format("echo 1 | sudo tee /sys/class/tty/{}/rx_trig_bytes", facts.name)});
    }
}

std::string joined(std::string_view first, std::string_view second) {
    return fmt::format("{}{}{}", first, !first.empty() && !second.empty() ? "; " : "", second);
}

PortAbility ability_of(std::string_view protocol, const LineSettings& line, bool inverted,
                       const PortKind& kind, const SerialFacts& facts) {
    if (const auto refusal = hardware_refusal(kind, facts, line)) {
        return {protocol, Ability::no, *refusal};
    }
    const bool usual = line.baud == kUsualBaud;
    if (kind.rates_unknown && !usual) {
        return {protocol, Ability::unknown,
                fmt::format("{}; `tribus doctor {}` tries it", kind.rates_note, facts.device)};
    }
    const bool doubtful = !usual || !kind.parity;
    return {protocol, Ability::yes,
            joined(inverted && !facts.pseudo_terminal ? kInverter : "",
                   doubtful ? kind.rates_note : "")};
}

}  // namespace

std::string_view ability_name(Ability ability) {
    switch (ability) {
        case Ability::yes:
            return "yes";
        case Ability::no:
            return "no";
        case Ability::unknown:
            break;
    }
    return "unknown";
}

PortOpinion judge_port(const SerialFacts& facts, bool asked_for) {
    PortOpinion opinion;
    PortFindings findings(facts, asked_for);
    judge_node(facts, findings);
    if (!facts.exists || !facts.serial) {
        opinion.findings = findings.take();
        return opinion;
    }
    const PortKind kind = kind_of(facts);
    opinion.kind = kind.name;
    opinion.abilities = {ability_of("i.Bus", kIbusLine, false, kind, facts),
                         ability_of("SBUS", kSbusLine, true, kind, facts),
                         ability_of("fast SBUS", kFastSbusLine, true, kind, facts),
                         ability_of("sensor bus", kIbusLine, false, kind, facts)};
    if (kind.usb) {
        opinion.abilities.back().because =
            "as a sensor it replies late; a UART of the board does not";
    }
    if (facts.kernel_console) {
        judge_console(facts, findings);
    }
    std::vector<PortUser> users;
    for (const PortUser& user : facts.users) {
        if (user.is_login) {
            judge_login(user, findings);
        } else {
            users.push_back(user);
        }
    }
    if (!users.empty()) {
        judge_users(users, findings);
    }
    if (facts.users_hidden && facts.users.empty() && asked_for) {
        findings.add(Severity::note, "port.users_hidden",
                     "cannot see whether programs of other users have it open", "",
                     "As root it works: `sudo tribus doctor " + facts.node + "`.");
    }
    judge_hardware(facts, kind, findings);
    opinion.findings = findings.take();
    return opinion;
}

}  // namespace tribus::doctor
