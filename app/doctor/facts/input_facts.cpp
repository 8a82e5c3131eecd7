#include "app/doctor/facts/input_facts.h"

#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/quotes.h"

namespace tribus::doctor {
namespace {

constexpr std::string_view kInputFolder = "/dev/input/";
constexpr const char* kUinput = "/dev/uinput";

InputFacts with_access(const KernelFiles& files, EvdevDeviceFacts device) {
    InputFacts facts{.device = std::move(device)};
    facts.access = access_to(files, facts.device.node.substr(1), R_OK);
    if (facts.access.exists) {
        facts.users = users_of(files, facts.device.node);
    }
    return facts;
}

Finding permission_finding(const InputFacts& facts, Severity severity) {
    const std::string& group = facts.access.group;
    const bool for_group = !group.empty() && group != "root";
    return {severity,
            "input.permission",
            facts.device.node,
            "you may not read it",
            "A service needs more: docs/service.md, \"Joysticks in the service\".",
            for_group
                ? fmt::format("It belongs to the group {}. Join it, then log in again:", group)
                : std::string("It belongs to root only. A rule of udev gives it to a group: "
                              "SUBSYSTEM==\"input\", KERNEL==\"event*\", GROUP=\"input\", "
                              "MODE=\"0660\""),
            for_group ? std::vector<std::string>{fmt::format("sudo usermod -aG {} $USER", group)}
                      : std::vector<std::string>{}};
}

Finding unnamed_finding(const EvdevDeviceFacts& device) {
    const bool by_address = !device.unique.empty();
    return {Severity::advice,
            "input.no_stable_name",
            device.node,
            "it has no name that stays",
            "After the next start, or when it comes back, this name may be another device.",
            fmt::format("A rule of udev gives it one, here /dev/input/pad, as a line of "
                        "/etc/udev/rules.d/70-pad.rules: SUBSYSTEM==\"input\", KERNEL==\"event*\", "
                        "ATTRS{{{}}}=={}, SYMLINK+=\"input/pad\"",
                        by_address ? "uniq" : "name",
                        in_quotes(by_address ? device.unique : device.name))};
}

/// Why it cannot be an input of a configuration at all.
std::optional<Finding> unusable(const InputFacts& facts, Severity severity) {
    const EvdevDeviceFacts& device = facts.device;
    const std::vector<std::string> lists{"ls /dev/input/by-id", "tribus doctor"};
    if (!facts.access.exists) {
        return Finding{
            severity,    "input.missing",
            device.node, "there is no such device",
            "",          "Is it plugged in or connected? These commands list the devices:",
            lists};
    }
    if (std::filesystem::path(device.node).filename().string().starts_with("js")) {
        return Finding{severity,
                       "input.old_device",
                       device.node,
                       "this is the device for old programs",
                       "",
                       "Name the one for events: below /dev/input/by-id it ends in "
                       "-event-joystick.",
                       lists};
    }
    if (!device.is_gamepad()) {
        return Finding{severity,
                       "input.no_gamepad",
                       device.node,
                       device.event.empty() ? std::string("this is no input device")
                                            : fmt::format("{} is no gamepad and no joystick",
                                                          in_quotes(device.name)),
                       "A gamepad has sticks and the buttons of a gamepad.",
                       "Name a gamepad; these commands list them:",
                       lists};
    }
    return std::nullopt;
}

}  // namespace

std::vector<InputFacts> look_at_gamepads(const KernelFiles& files) {
    std::vector<InputFacts> found;
    for (EvdevDeviceFacts& device : find_evdev_devices(files.at(""))) {
        if (device.is_gamepad()) {
            found.push_back(with_access(files, std::move(device)));
        }
    }
    return found;
}

InputFacts look_at_input(const KernelFiles& files, const std::string& device) {
    return with_access(files, look_at_evdev_device(device, files.at("")));
}

UinputFacts look_at_uinput(const KernelFiles& files) {
    return {.access = access_to(files, std::string(kUinput).substr(1), W_OK)};
}

bool names_input(const KernelFiles& files, const std::string& device) {
    return device.starts_with(kInputFolder) ||
           (device.starts_with('/') && !look_at_evdev_device(device, files.at("")).event.empty());
}

std::vector<Finding> judge_input(const InputFacts& facts, bool asked_for) {
    const Severity hindrance = asked_for ? Severity::problem : Severity::advice;
    if (auto finding = unusable(facts, hindrance)) {
        return {std::move(*finding)};
    }
    std::vector<Finding> findings;
    if (!facts.access.may_open) {
        findings.push_back(permission_finding(facts, hindrance));
    } else if (facts.refusal && !facts.refusal->empty()) {
        findings.push_back(
            {hindrance, "input.cannot_open", facts.device.node, *facts.refusal, "",
             facts.users.users.empty() && facts.users.hidden
                 ? "As root doctor sees which: `sudo tribus doctor " + facts.device.node + "`."
                 : ""});
    }
    if (!facts.users.users.empty()) {
        findings.push_back({Severity::note, "input.in_use", facts.device.node,
                            "it is open in " + names_of_users(facts.users.users),
                            "`tribus run` takes it for itself, unless grab = false; then that "
                            "program gets nothing. A program that has taken it keeps it from "
                            "tribus.",
                            ""});
    }
    if (!facts.device.has_stable_name()) {
        findings.push_back(unnamed_finding(facts.device));
    }
    return findings;
}

std::vector<Finding> judge_uinput(const UinputFacts& facts, bool asked_for) {
    const Severity severity = asked_for ? Severity::problem : Severity::note;
    const std::string why = "Only virtual joysticks need it (protocol = \"joystick\").";
    if (!facts.access.exists) {
        return {
            {severity,
             "uinput.missing",
             kUinput,
             "the kernel's module uinput is not loaded",
             why,
             "Load it, now and at each start:",
             {"sudo modprobe uinput", "echo uinput | sudo tee /etc/modules-load.d/uinput.conf"}}};
    }
    if (facts.access.may_open) {
        return {};
    }
    const std::string& group = facts.access.group;
    const bool for_group = !group.empty() && group != "root";
    return {{severity, "uinput.permission", kUinput, "you may not open it",
             why + " A service needs more: docs/service.md, \"Joysticks in the service\".",
             for_group
                 ? fmt::format("It belongs to the group {}. Join it, then log in again:", group)
                 : std::string("It belongs to root only. The package has a rule of udev that "
                               "gives it to the group uinput: KERNEL==\"uinput\", "
                               "SUBSYSTEM==\"misc\", GROUP=\"uinput\", MODE=\"0660\""),
             for_group ? std::vector<std::string>{fmt::format("sudo usermod -aG {} $USER", group)}
                       : std::vector<std::string>{}}};
}

std::string describe(const InputFacts& facts) {
    const EvdevDeviceFacts& device = facts.device;
    const auto number = [](std::size_t count, std::string_view one, std::string_view more) {
        return fmt::format("{} {}", count, count == 1 ? one : more);
    };
    return device.event.empty()
               ? std::string()
               : fmt::format("{} {}, {}, {}", device.is_gamepad() ? "gamepad" : "input device",
                             in_quotes(device.name), number(device.axes.size(), "axis", "axes"),
                             number(device.buttons.size(), "button", "buttons"));
}

std::vector<std::string> configuration_lines(const InputFacts& facts) {
    if (!facts.device.is_gamepad()) {
        return {};
    }
    return {"[input.pad]", "protocol = \"gamepad\"",
            "device   = " + in_quotes(facts.device.device)};
}

}  // namespace tribus::doctor
