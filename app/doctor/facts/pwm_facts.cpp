#include "app/doctor/facts/pwm_facts.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace tribus::doctor {
namespace {

constexpr std::string_view kPwmNames = "pwmchip";

std::string name_of_chip(const std::string& device) {
    return std::filesystem::path(device).filename().string();
}

PwmFacts facts_of_chip(const KernelFiles& files, const PwmChipFacts& chip) {
    PwmFacts facts{.chip = chip};
    facts.access = chip.device.empty()
                       ? access_to(files, fmt::format("{}/{}/export", kPwmFolder, chip.name), W_OK)
                       : access_to(files, fmt::format("{}/{}", kPwmDeviceFolder, chip.name), W_OK);
    for (std::size_t output = 0; output < chip.outputs; ++output) {
        if (const auto state = look_at(chip, output)) {
            facts.taken.emplace_back(output, *state);
        }
    }
    return facts;
}

Finding pwm_permission(const PwmFacts& facts, Severity severity) {
    const std::string& group = facts.access.group;
    const bool for_group = !group.empty() && group != "root";
    return {
        severity,
        "pwm.permission",
        facts.chip.name,
        "you may not take its outputs",
        "A service needs more: docs/service.md, \"PWM in the service\".",
        for_group
            ? fmt::format("Its files belong to the group {}. Join it, then log in again:", group)
            : std::string("Its files belong to root only. The package has a rule of udev that "
                          "gives them to the group gpio; where it is installed:"),
        {for_group ? fmt::format("sudo usermod -aG {} $USER", group)
                   : std::string("sudo udevadm trigger --action=change "
                                 "--subsystem-match=pwm")}};
}

}  // namespace

std::vector<PwmFacts> look_at_pwm_chips(const KernelFiles& files) {
    std::vector<PwmFacts> found;
    for (const PwmChipFacts& chip : find_pwm_chips(files.at(""))) {
        found.push_back(facts_of_chip(files, chip));
    }
    return found;
}

bool names_pwm_chip(const KernelFiles& files, const std::string& device) {
    return name_of_chip(device).starts_with(kPwmNames) || !look_at_pwm_chip(files, device).empty();
}

std::vector<PwmFacts> look_at_pwm_chip(const KernelFiles& files, const std::string& device) {
    std::vector<PwmFacts> found = look_at_pwm_chips(files);
    std::erase_if(found, [name = name_of_chip(device)](const PwmFacts& facts) {
        return facts.chip.name != name && facts.chip.driver != name;
    });
    return found;
}

Finding unknown_pwm_chip(const KernelFiles& files, const std::string& device) {
    const std::string name = name_of_chip(device);
    const auto chip = find_pwm_chip(name, files.at(""));
    const std::string error = chip ? std::string() : chip.error();
    return {Severity::problem,
            "pwm.missing",
            name,
            error.substr(std::min(error.size(), name.size() + std::string_view(": ").size())),
            "",
            ""};
}

std::vector<Finding> judge_pwm(const PwmFacts& facts, bool asked_for) {
    std::vector<Finding> findings;
    if (!facts.access.may_open) {
        findings.push_back(pwm_permission(facts, asked_for ? Severity::problem : Severity::advice));
    }
    std::vector<std::size_t> off;
    std::vector<std::size_t> on;
    for (const auto& [output, state] : facts.taken) {
        (state.on ? on : off).push_back(output);
    }
    if (!off.empty()) {
        findings.push_back(
            {Severity::note, "pwm.taken", facts.chip.name,
             fmt::format("taken, and off: {} {}", off.size() == 1 ? "output" : "outputs",
                         fmt::join(off, ", ")),
             "A program has them, or had them and did not give them back. tribus "
             "uses them nevertheless.",
             ""});
    }
    if (!on.empty()) {
        findings.push_back({Severity::note,
                            "pwm.on",
                            facts.chip.name,
                            fmt::format("sending pulses: {} {}",
                                        on.size() == 1 ? "output" : "outputs", fmt::join(on, ", ")),
                            "If no program drives them, the chip repeats these pulses for ever.",
                            "This switches off what a configuration names:",
                            {"tribus pwm --off CONFIG"}});
    }
    return findings;
}

}  // namespace tribus::doctor
