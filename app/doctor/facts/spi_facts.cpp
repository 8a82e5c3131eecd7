#include "app/doctor/facts/spi_facts.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

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
        "A service needs more: docs/service.md, \"SPI in the service\".",
        for_group ? fmt::format("It belongs to the group {}. Join it, then log in again:", group)
                  : std::string("It belongs to root only. The package has a rule of udev that "
                                "gives it to the group gpio; where it is installed:"),
        {for_group ? fmt::format("sudo usermod -aG {} $USER", group)
                   : std::string("sudo udevadm trigger --action=change --subsystem-match=spidev")}};
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
    if (facts.refusal && !facts.refusal->empty()) {
        return {{severity, "spi.cannot_open", facts.device, *facts.refusal, "", ""}};
    }
    return {};
}

std::vector<std::string> configuration_lines(const SpiFacts& facts) {
    if (!facts.access.may_open || (facts.refusal && !facts.refusal->empty())) {
        return {};
    }
    return {"[output.trainer]", "protocol = \"ppm\"", "line     = " + in_quotes(facts.device)};
}

}  // namespace tribus::doctor
