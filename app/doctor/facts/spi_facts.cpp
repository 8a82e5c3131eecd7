#include "app/doctor/facts/spi_facts.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/doctor/facts/port_users.h"
#include "core/quotes.h"

namespace tribus::doctor {
namespace {

constexpr std::string_view kSpiNames = "spidev";

Finding spi_permission(const SpiFacts& facts, Severity severity) {
    const std::string& group = facts.access.group;
    const bool for_group = !group.empty() && group != "root";
    return {
        severity,
        "spi.permission",
        facts.device,
        "you may not open it",
        "",
        for_group ? fmt::format("It belongs to the group {}. Join it, then log in again:", group)
                  : std::string("It belongs to root only. The package has a rule of udev that "
                                "gives it to the group spi; where it is installed:"),
        {for_group ? fmt::format("sudo usermod -aG {} $USER", group)
                   : std::string("sudo udevadm trigger --action=change --subsystem-match=spidev")}};
}

/// By how much longer a byte takes after the frames.
double drift_percent(const SpiLoopback& loopback) {
    constexpr double kPercent = 100;
    const auto before = static_cast<double>(loopback.byte_before.count());
    const auto after = static_cast<double>(loopback.byte_after.count());
    return (after / before - 1) * kPercent;
}

std::vector<Finding> loopback_findings(const std::string& device, const SpiLoopback& loopback) {
    constexpr double kMostDriftPercent = 1.5;
    std::vector<Finding> findings;
    const auto add = [&](std::string_view id, std::string what, std::string action) {
        findings.push_back({Severity::problem, id, device, std::move(what), "", std::move(action)});
    };
    if (loopback.silent == loopback.sent) {
        add("spi.no_wire", "no frame came back",
            "Put one wire from MOSI (GPIO10, pin 19 of a Raspberry Pi) to MISO (GPIO9, pin 21), "
            "and nothing else.");
    } else if (loopback.right != loopback.sent) {
        add("spi.frames_lost",
            fmt::format("{} of {} frames came back wrong", loopback.sent - loopback.right,
                        loopback.sent),
            "Put one short wire from MOSI to MISO, and nothing else. If it stays so, take another "
            "port.");
    }
    if (std::abs(drift_percent(loopback)) > kMostDriftPercent) {
        add("spi.drift",
            fmt::format("its clock changed by {:.1f} % meanwhile", drift_percent(loopback)),
            "Fix the core's clock: core_freq_min=500 (Raspberry Pi 4) or core_freq=250 (Raspberry "
            "Pi 3) in config.txt.");
    }
    return findings;
}

}  // namespace

std::vector<SpiFacts> look_at_spi_ports(const KernelFiles& files) {
    std::vector<SpiFacts> found;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(files.at("dev"), error)) {
        const std::string name = entry.path().filename();
        if (name.starts_with(kSpiNames)) {
            found.push_back(look_at_spi_port(files, name));
        }
    }
    std::ranges::sort(found, {}, &SpiFacts::device);
    return found;
}

SpiFacts look_at_spi_port(const KernelFiles& files, const std::string& device) {
    SpiFacts facts{.device = device.starts_with('/') ? device : "/dev/" + device};
    facts.access = access_to(files, facts.device.substr(1), R_OK | W_OK);
    return facts;
}

bool names_spi_port(const std::string& device) {
    return std::filesystem::path(device).filename().string().starts_with(kSpiNames);
}

std::vector<Finding> judge_spi_port(const SpiFacts& facts, bool asked_for) {
    const Severity severity = asked_for ? Severity::problem : Severity::note;
    if (!facts.access.exists) {
        return {{severity,
                 "spi.missing",
                 facts.device,
                 "there is no such device",
                 "",
                 "On a Raspberry Pi dtparam=spi=on in config.txt makes /dev/spidev0.0. This "
                 "command lists the ports:",
                 {"ls /dev/spidev*"}}};
    }
    if (!facts.access.may_open) {
        return {spi_permission(facts, severity)};
    }
    if (!facts.users.empty()) {
        return {{severity, "spi.in_use", facts.device,
                 "it is in use by " + names_of_users(facts.users),
                 "What is sent here would move the servos there, at a rate of this program.",
                 "Stop that program first."}};
    }
    if (facts.refusal && !facts.refusal->empty()) {
        return {{severity, "spi.cannot_open", facts.device, *facts.refusal, "", ""}};
    }
    std::vector<Finding> findings;
    if (!facts.no_output.empty()) {
        findings.push_back({Severity::advice, "spi.cannot_draw", facts.device, facts.no_output, "",
                            "Use it for a receiver, at MISO, or take another port for servos."});
    }
    if (facts.loopback) {
        std::ranges::move(loopback_findings(facts.device, *facts.loopback),
                          std::back_inserter(findings));
    }
    return findings;
}

std::string describe(const SpiLoopback& loopback) {
    constexpr double kNsPerSecond = 1e9;
    const auto byte_ns = static_cast<double>(loopback.byte_before.count());
    return fmt::format(
        "loopback: {} of {} frames came back; at {} Hz a byte takes {:.3f} us, {:.2f} clocks; "
        "afterwards {:+.1f} %",
        loopback.right, loopback.sent, loopback.hz, byte_ns / 1000,
        byte_ns * loopback.hz / kNsPerSecond, drift_percent(loopback));
}

std::vector<std::string> configuration_lines(const SpiFacts& facts) {
    if (!facts.access.may_open || !facts.users.empty() ||
        (facts.refusal && !facts.refusal->empty())) {
        return {};
    }
    const std::string table = facts.no_output.empty() ? "[output.servos]" : "[input.receiver]";
    return {table, "protocol = \"sbus\"", "spi      = " + in_quotes(facts.device)};
}

}  // namespace tribus::doctor
